// The walk through one slab's cells that marching cubes is: rows of masks, vertices, triangles.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/classify.hpp"
#include "gp_firmware/surface/edge_vertex.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "gp_firmware/volume/typed.hpp"
#include "gp_firmware/volume/voxel_gradient.hpp"

namespace pxpl5::gp {

inline constexpr std::size_t max_triangles_per_cell = 12;

/// Makes room for `count` elements, by doubling; never shrinks. The elements beyond those in use
/// keep what an earlier surface left there, so that a mesh that is extracted again costs no
/// clearing.
template <class T>
void make_room(std::vector<T>& elements, std::size_t count) {
    if (elements.size() >= count) return;
    const bool fits = count <= elements.capacity();
    elements.resize(fits ? elements.capacity() : std::max(count, 2 * elements.capacity()));
}

/// What a walk leaves in the mesh beside positions and triangles.
enum class Wanted : std::uint8_t { measures, mesh, mesh_with_origins };

/// Goes up the rows of a slab. Of edges it remembers the vertices of two rows only; rows y and
/// y - 1 alternate in the arrays with [parity].
template <class T>
class SlabWalk {
  public:
    SlabWalk(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
             SlabMesh& out, Wanted wanted)
        : shape_(store.shape()),
          isovalue_(isovalue),
          table_(table),
          out_(out),
          frame_(shape_.voxel_to_patient),
          flip_(glm::determinant(glm::dmat3(shape_.voxel_to_patient)) < 0 ? 1 : 0),
          words_(mask_words(shape_.nx)),
          slab_(slab),
          wanted_(wanted),
          origins_(wanted == Wanted::mesh_with_origins) {
        for (const int s : {0, 1}) {
            slices_[at(s)] = &store.slice(slab + s);
            values_[at(s)] = typed<T>(slices_[at(s)]->values);
            z_factors_[at(s)] = z_factor(shape_, slab + s);
            if (!shape_.holds_gradients())
                estimates_[at(s)] = VoxelGradients<T>(shape_, store.neighbours(slab + s));
        }
        const auto nx = static_cast<std::size_t>(shape_.nx);
        // One word more: the right neighbour of a row's last word.
        for (auto& masks : masks_)
            for (auto& mask : masks) mask.assign(words_ + 1, 0);
        for (auto* edges : {&x_edges_[0], &x_edges_[1]})
            for (auto& row : *edges) row.resize(nx);
        for (auto& row : y_edges_) row.resize(nx);
        for (auto& row : z_edges_) row.resize(nx);
    }

    /// Goes up the rows until `triangles` more are there. Returns false when all rows are done.
    bool advance(std::size_t triangles) {
        const std::size_t enough = index_count_ / 3 + triangles;
        for (; next_row_ < shape_.ny; ++next_row_) {
            if (index_count_ / 3 >= enough) return true;
            const int y = next_row_;
            classify(y);
            make_row_vertices(y);
            if (y == 0) continue;
            if (row_is_crossed()) {
                make_cells(y - 1);
            } else {
                ++out_.counts.rows_skipped;
            }
        }
        out_.vertices.resize(vertex_count_);
        out_.keys.resize(vertex_count_);
        out_.indices.resize(index_count_);
        out_.origins.resize(origins_ ? index_count_ / 3 : 0);
        out_.counts.triangles = static_cast<std::uint32_t>(index_count_ / 3);
        const bool top = slab_ == shape_.slab_count() - 1;
        out_.counts.vertices = static_cast<std::uint32_t>(vertex_count_ - (top ? 0 : upper_count_));
        return false;
    }

  private:
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }

    /// Inlined by force: called, it would take a third of a small volume's extraction.
    [[gnu::always_inline]] Gradient gradient(std::size_t slice, std::size_t x,
                                             std::size_t y) const {
        if (shape_.holds_gradients()) [[likely]] {
            return slices_[slice]->gradients[y * at(shape_.nx) + x];
        }
        return estimated_gradient(slice, x, y);
    }
    [[gnu::noinline]] Gradient estimated_gradient(std::size_t slice, std::size_t x,
                                                  std::size_t y) const {
        return estimates_[slice].at(x, y);
    }

    void classify(int y) {
        const std::size_t row = at(y & 1);
        for (const std::size_t s : {0U, 1U})
            sides_[row][s] = classify_row(shape_, *slices_[s], y, isovalue_,
                                          std::span(masks_[row][s]).first(words_));
    }

    /// Whether the surface can cross a cell between the last two rows, by their ranges.
    bool row_is_crossed() const {
        const RowSide side = sides_[0][0];
        return side == RowSide::mixed || sides_[0][1] != side || sides_[1][0] != side ||
               sides_[1][1] != side;
    }

    /// Vertices on the edges of row y and on those between it and row y - 1.
    void make_row_vertices(int y) {
        const std::size_t row = at(y & 1);
        const auto& mask = masks_[row];
        for (const int s : {0, 1}) {
            if (sides_[row][at(s)] != RowSide::mixed) continue;
            const std::size_t before = vertex_count_;
            const auto& m = mask[at(s)];
            make_vertices(x_edges_[row][at(s)], {0, y, s}, 0, [&](std::size_t w) {
                const std::uint64_t right = m[w] >> 1 | m[w + 1] << 63;
                return (m[w] ^ right) & cells_in_word(w);
            });
            if (s == 1) upper_count_ += vertex_count_ - before;
        }
        if (sides_[row][0] == RowSide::mixed || sides_[row][0] != sides_[row][1])
            make_vertices(z_edges_[row], {0, y, 0}, 2,
                          [&](std::size_t w) { return mask[0][w] ^ mask[1][w]; });
        if (y > 0) make_vertices_between_rows(y);
    }

    void make_vertices_between_rows(int y) {
        for (const int s : {0, 1}) {
            const RowSide side = sides_[0][at(s)];
            if (side != RowSide::mixed && side == sides_[1][at(s)]) continue;
            const std::size_t before = vertex_count_;
            make_vertices(y_edges_[at(s)], {0, y - 1, s}, 1,
                          [&](std::size_t w) { return masks_[0][at(s)][w] ^ masks_[1][at(s)][w]; });
            if (s == 1) upper_count_ += vertex_count_ - before;
        }
    }

    /// Bits of the word's cells: a row has one less than voxels.
    std::uint64_t cells_in_word(std::size_t w) const {
        const std::size_t rest = static_cast<std::size_t>(shape_.nx) - 1 - w * 64;
        return rest >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << rest) - 1;
    }

    /// Makes the vertices of a row of edges along `axis`.
    /// start    Voxel of the row's first edge; z counts from the slab.
    /// crossed  Crossed edges of a word.
    template <class Crossed>
    void make_vertices(std::vector<std::uint32_t>& edges, glm::ivec3 start, int axis,
                       Crossed crossed) {
        const std::size_t row = at(start.y) * at(shape_.nx);
        const std::size_t lower = at(start.z), upper = lower + (axis == 2 ? 1 : 0);
        const std::size_t x_step = axis == 0 ? 1 : 0, y_step = axis == 1 ? 1 : 0;
        const std::size_t step = x_step + y_step * at(shape_.nx);
        const T* values_0 = values_[lower] + row;
        const T* values_1 = values_[upper] + row + step;
        const std::uint64_t first_key =
            4 * (shape_.slice_voxels() * at(slab_ + start.z) + row) + at(axis);
        const glm::dvec3 p_start(0, start.y, shape_.place(slab_ + start.z));
        const double length = axis == 2 ? shape_.height(slab_) : 1;
        for (std::size_t w = 0; w < words_; ++w) {
            std::uint64_t bits = crossed(w);
            if (bits == 0) continue;
            const std::size_t room = vertex_count_ + 64;
            make_room(out_.vertices, room);
            make_room(out_.keys, room);
            for (; bits != 0; bits &= bits - 1) {
                const std::size_t x = w * 64 + static_cast<std::size_t>(std::countr_zero(bits));
                const auto value_0 = static_cast<double>(values_0[x]);
                const auto value_1 = static_cast<double>(values_1[x]);
                const double t = crossing(value_0, value_1, isovalue_);
                glm::dvec3 p = p_start;
                p.x = static_cast<double>(x);
                p[axis] += t * length;
                Vertex& vertex = out_.vertices[vertex_count_];
                vertex.p_voxel = glm::vec3(p);
                edges[x] = static_cast<std::uint32_t>(vertex_count_++);
                if (wanted_ == Wanted::measures) continue;
                const EdgeEnds ends{value_0,
                                    value_1,
                                    gradient(lower, x, at(start.y)),
                                    gradient(upper, x + x_step, at(start.y) + y_step),
                                    z_factors_[lower],
                                    z_factors_[upper]};
                vertex.normal = edge_normal(ends, static_cast<float>(t), axis, isovalue_, frame_);
                vertex.unused = 0;
                out_.keys[edges[x]] = first_key + 4 * x;
            }
        }
    }

    /// Triangles of the cells between rows y and y + 1.
    void make_cells(int y) {
        const std::size_t low = at(y & 1), high = 1 - low;
        const std::array<const std::uint64_t*, 4> masks = {
            masks_[low][0].data(), masks_[high][0].data(), masks_[low][1].data(),
            masks_[high][1].data()};
        const std::array<const std::uint32_t*, cell_edge_count> edges = {
            x_edges_[low][0].data(),  x_edges_[high][0].data(), x_edges_[low][1].data(),
            x_edges_[high][1].data(), y_edges_[0].data(),       y_edges_[0].data() + 1,
            y_edges_[1].data(),       y_edges_[1].data() + 1,   z_edges_[low].data(),
            z_edges_[low].data() + 1, z_edges_[high].data(),    z_edges_[high].data() + 1};
        for (std::size_t w = 0; w < words_; ++w) {
            std::array<std::uint64_t, 4> left, right;
            std::uint64_t any = 0, all = ~std::uint64_t{0};
            for (std::size_t i = 0; i < 4; ++i) {
                left[i] = masks[i][w];
                right[i] = left[i] >> 1 | masks[i][w + 1] << 63;
                any |= left[i] | right[i];
                all &= left[i] & right[i];
            }
            std::uint64_t active = any & ~all & cells_in_word(w);
            if (active == 0) continue;
            const auto cells = static_cast<std::size_t>(std::popcount(active));
            out_.counts.cells_active += static_cast<std::uint32_t>(cells);
            make_room(out_.indices, index_count_ + 3 * max_triangles_per_cell * cells);
            if (origins_) make_room(out_.origins, out_.indices.size() / 3 + 1);
            for (; active != 0; active &= active - 1) {
                const int bit = std::countr_zero(active);
                std::uint64_t inside = 0;
                for (std::size_t i = 0; i < 4; ++i)
                    inside |= (left[i] >> bit & 1) << 2 * i | (right[i] >> bit & 1) << (2 * i + 1);
                make_cell(static_cast<std::uint8_t>(inside), w * 64 + at(bit), y, edges);
            }
        }
    }

    void make_cell(std::uint8_t inside, std::size_t x, int y,
                   const std::array<const std::uint32_t*, cell_edge_count>& edges) {
        const std::uint8_t ambiguous = table_.ambiguous[inside];
        std::uint8_t joined = 0;
        if (ambiguous != 0) {
            ++out_.counts.cells_ambiguous;
            if (table_.decides_faces) joined = decide_faces(inside, ambiguous, x, y);
        }
        const CaseEntry& entry = table_.entry(inside, joined);
        std::uint32_t centre = 0;
        if (entry.ring_size != 0) centre = make_centre(entry, x, y, edges);
        const std::uint8_t* corners = table_.corners.data() + entry.first_corner;
        std::uint32_t* indices = out_.indices.data() + index_count_;
        const auto vertex = [&](std::size_t i) {
            return corners[i] == centre_corner ? centre : edges[corners[i]][x];
        };
        const std::size_t count = std::size_t{entry.triangle_count} * 3;
        for (std::size_t i = 0; i < count; i += 3) {
            indices[i] = vertex(i);
            indices[i + 1] = vertex(i + 1 + flip_);
            indices[i + 2] = vertex(i + 2 - flip_);
        }
        if (origins_)
            note_origins({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), inside,
                          joined, 0, 0},
                         entry.triangle_count);
        index_count_ += count;
    }

    /// Of a cell's triangles, which begin at index_count_.
    void note_origins(Origin origin, std::uint8_t triangle_count) {
        Origin* to = out_.origins.data() + index_count_ / 3;
        for (; origin.triangle < triangle_count; ++origin.triangle) to[origin.triangle] = origin;
    }

    /// On which ambiguous faces the inside corners are joined: where the bilinear interpolation
    /// of the face has its saddle inside. Both products commute, so that both cells at a face
    /// compute the same; ties are separated.
    std::uint8_t decide_faces(std::uint8_t inside, unsigned ambiguous, std::size_t x, int y) const {
        const std::size_t nx = at(shape_.nx), voxel = at(y) * nx + x;
        const auto above = [&](int corner) {
            const std::size_t offset = (corner & 1 ? 1U : 0U) + (corner & 2 ? nx : 0U);
            return static_cast<double>(values_[at(corner >> 2)][voxel + offset]) - isovalue_;
        };
        unsigned joined = 0;
        for (; ambiguous != 0; ambiguous &= ambiguous - 1) {
            const auto corner = face_corners(std::countr_zero(ambiguous));
            const double even = above(corner[0]) * above(corner[2]);
            const double odd = above(corner[1]) * above(corner[3]);
            const bool even_inside = (inside >> corner[0] & 1) != 0;
            if (even_inside ? even > odd : odd > even) joined |= ambiguous & (~ambiguous + 1);
        }
        return static_cast<std::uint8_t>(joined);
    }

    /// The cell's own vertex: the mean of a ring of others, with their mean normal.
    std::uint32_t make_centre(const CaseEntry& entry, std::size_t x, int y,
                              const std::array<const std::uint32_t*, cell_edge_count>& edges) {
        glm::dvec3 sum(0);
        glm::vec3 n(0);
        const auto ring = table_.ring_of(entry);
        for (const std::uint8_t edge : ring) {
            const Vertex& vertex = out_.vertices[edges[edge][x]];
            sum += glm::dvec3(vertex.p_voxel);
            n += glm::vec3(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
        }
        const float length_squared = n.x * n.x + n.y * n.y + n.z * n.z;
        make_room(out_.vertices, vertex_count_ + 1);
        make_room(out_.keys, vertex_count_ + 1);
        Vertex& centre = out_.vertices[vertex_count_];
        centre.p_voxel = glm::vec3(sum / static_cast<double>(ring.size()));
        // Normals that cancel out give no direction; then the first of the ring is as good as any.
        centre.normal = length_squared > 0 ? pack_normal(n, length_squared)
                                           : out_.vertices[edges[ring[0]][x]].normal;
        centre.unused = 0;
        out_.keys[vertex_count_] =
            4 * (shape_.slice_voxels() * at(slab_) + at(y) * at(shape_.nx) + x) + 3;
        return static_cast<std::uint32_t>(vertex_count_++);
    }

    const VolumeShape& shape_;
    double isovalue_;
    const CaseTable& table_;
    SlabMesh& out_;
    NormalFrame frame_;
    std::size_t flip_;  ///< 1 where voxel_to_patient mirrors, so that triangles must turn too.
    std::size_t words_;
    int slab_;
    int next_row_ = 0;
    Wanted wanted_;
    bool origins_;
    std::array<const HeldSlice*, 2> slices_{};
    std::array<const T*, 2> values_{};
    std::array<VoxelGradients<T>, 2> estimates_;  ///< Only if gradients are not held.
    std::array<float, 2> z_factors_{};
    std::array<std::array<std::vector<std::uint64_t>, 2>, 2> masks_;    ///< [parity][slice]
    std::array<std::array<RowSide, 2>, 2> sides_{};                     ///< [parity][slice]
    std::array<std::array<std::vector<std::uint32_t>, 2>, 2> x_edges_;  ///< [parity][slice]
    std::array<std::vector<std::uint32_t>, 2> y_edges_;                 ///< [slice]
    std::array<std::vector<std::uint32_t>, 2> z_edges_;                 ///< [parity]
    std::size_t vertex_count_ = 0, index_count_ = 0;
    std::size_t upper_count_ = 0;  ///< Vertices in the upper slice, which the next slab owns.
};

}  // namespace pxpl5::gp
