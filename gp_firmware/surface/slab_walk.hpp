// The walk through one slab's cells that marching cubes is: rows of masks, vertices, triangles.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/cell_row.hpp"
#include "gp_firmware/surface/classify.hpp"
#include "gp_firmware/surface/edge_batch.hpp"
#include "gp_firmware/surface/make_room.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "gp_firmware/volume/typed.hpp"
#include "gp_firmware/volume/voxel_gradient.hpp"

namespace pxpl5::gp {

inline constexpr std::size_t max_triangles_per_cell = 12;

/// What a walk leaves in the mesh beside positions and triangles.
enum class Wanted : std::uint8_t { measures, mesh, mesh_with_origins };

/// Goes up the rows of a slab. Of edges it remembers the vertices of two rows only, in slots
/// (case_slots.hpp); rows y and y - 1 alternate in the arrays with [parity].
template <class T>
class SlabWalk {
  public:
    SlabWalk(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
             SlabMesh& out, Wanted wanted, isa::VectorTarget target)
        : shape_(store.shape()),
          table_(table),
          slots_(table.slots[mirrors(shape_) ? 1 : 0]),
          out_(out),
          words_(mask_words(shape_.nx)),
          slab_(slab),
          wanted_(wanted),
          target_(target),
          origins_(wanted == Wanted::mesh_with_origins) {
        frame_.isovalue = isovalue;
        frame_.height = shape_.height(slab);
        frame_.normals = NormalFrame(shape_.voxel_to_patient);
        for (const int s : {0, 1}) {
            slices_[at(s)] = &store.slice(slab + s);
            values_[at(s)] = typed<T>(slices_[at(s)]->values);
            frame_.places[at(s)] = shape_.place(slab + s);
            frame_.z_factors[at(s)] = z_factor(shape_, slab + s);
            take_source(store, s);
        }
        // One word more: the right neighbour of a row's last word.
        for (auto& masks : masks_) {
            for (auto& mask : masks) {
                mask.assign(words_ + 1, 0);
            }
        }
        vertices_.resize(slots_per_voxel * at(shape_.nx));
        cells_.resize(at(shape_.nx));
    }

    /// Goes up the rows until `triangles` more are there. Returns false when all rows are done.
    bool advance(std::size_t triangles) {
        const std::size_t enough = index_count_ / 3 + triangles;
        for (; next_row_ < shape_.ny; ++next_row_) {
            if (index_count_ / 3 >= enough) {
                return true;
            }
            const int y = next_row_;
            classify(y);
            make_row_vertices(y);
            if (y == 0) {
                continue;
            }
            if (row_is_crossed()) {
                make_cells(y - 1);
            } else {
                ++out_.counts.rows_skipped;
            }
        }
        flush();
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

    /// Whether triangles must turn, because voxel_to_patient mirrors.
    static bool mirrors(const VolumeShape& shape) {
        return glm::determinant(glm::dmat3(shape.voxel_to_patient)) < 0;
    }

    /// Where the gradients of slice 0 or 1 come from.
    void take_source(const SliceStore& store, int s) {
        const HeldSlice& slice = *slices_[at(s)];
        if (shape_.holds_gradients()) {
            needed_[at(s)] = reinterpret_cast<const std::byte*>(slice.gradients.data());
            needed_bytes_ = wanted_ == Wanted::measures ? 0 : sizeof(Gradient);
        } else {
            const SliceNeighbours slices = store.neighbours(slab_ + s);
            estimates_[at(s)] = VoxelGradients<T>(shape_, slices);
            // Of the slices that they take the walk reads the slab's two anyway.
            needed_[at(s)] = (s == 0 ? slices.below : slices.above).data();
            needed_bytes_ = wanted_ == Wanted::measures ? 0 : sizeof(T);
        }
    }

    void classify(int y) {
        const std::size_t row = at(y & 1);
        for (const std::size_t s : {0U, 1U}) {
            sides_[row][s] = classify_row(shape_, *slices_[s], y, frame_.isovalue,
                                          std::span(masks_[row][s]).first(words_));
        }
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
        for (const std::size_t s : {0U, 1U}) {
            if (sides_[row][s] != RowSide::mixed) {
                continue;
            }
            const std::size_t before = vertex_count_;
            const auto& m = mask[s];
            make_edges({y, x_slot(row, s), along_slice(s)}, [&](std::size_t w) {
                const std::uint64_t right = m[w] >> 1 | m[w + 1] << 63;
                return (m[w] ^ right) & cells_in_word(w);
            });
            if (s == 1) {
                upper_count_ += vertex_count_ - before;
            }
        }
        if (sides_[row][0] == RowSide::mixed || sides_[row][0] != sides_[row][1]) {
            make_edges({y, z_slot(row), along_z | upper_end_above},
                       [&](std::size_t w) { return mask[0][w] ^ mask[1][w]; });
        }
        if (y > 0) {
            make_vertices_between_rows(y);
        }
    }

    void make_vertices_between_rows(int y) {
        for (const std::size_t s : {0U, 1U}) {
            const RowSide side = sides_[0][s];
            if (side != RowSide::mixed && side == sides_[1][s]) {
                continue;
            }
            const std::size_t before = vertex_count_;
            make_edges({y - 1, y_slot(s), along_y | along_slice(s)},
                       [&](std::size_t w) { return masks_[0][s][w] ^ masks_[1][s][w]; });
            if (s == 1) {
                upper_count_ += vertex_count_ - before;
            }
        }
    }

    static std::uint32_t along_slice(std::size_t s) {
        return s == 0 ? 0U : lower_end_above | upper_end_above;
    }

    /// Bits of the word's cells: a row has one less than voxels.
    std::uint64_t cells_in_word(std::size_t w) const {
        const std::size_t rest = static_cast<std::size_t>(shape_.nx) - 1 - w * 64;
        return rest >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << rest) - 1;
    }

    /// Parallel edges of a row.
    struct EdgeRow {
        int y = 0;  ///< Of their lower ends.
        std::size_t slot = 0;
        std::uint32_t kind = 0;  ///< EdgeKind.
    };

    /// Lists the crossed edges of a row in the batch, and begins to fetch what their gradients come
    /// from: that is seldom in the cache, and the edges of a batch wait for it together.
    /// crossed  Crossed edges of a word.
    template <class Crossed>
    void make_edges(const EdgeRow& row, Crossed crossed) {
        const std::size_t nx = at(shape_.nx), voxel = at(row.y) * nx;
        const std::size_t lower = row.kind & lower_end_above ? 1 : 0;
        const std::size_t upper = row.kind & upper_end_above ? 1 : 0;
        const std::size_t axis = row.kind & along_z ? 2 : row.kind & along_y ? 1 : 0;
        const std::size_t step = axis == 0 ? 1 : axis == 1 ? nx : 0;  // Within the slice.
        const T* values_0 = values_[lower] + voxel;
        const T* values_1 = values_[upper] + voxel + step;
        const std::byte* needed_0 = needed_[lower] + voxel * needed_bytes_;
        const std::byte* needed_1 = needed_[upper] + (voxel + step) * needed_bytes_;
        const std::uint32_t row_and_kind =
            static_cast<std::uint32_t>(row.y) << edge_kind_bits | row.kind;
        const std::uint64_t first_key =
            4 * (shape_.slice_voxels() * (at(slab_) + lower) + voxel) + axis;
        std::uint32_t* slots = vertices_.data() + row.slot;
        const std::size_t vertices_before = vertex_count_;
        for (std::size_t w = 0; w < words_; ++w) {
            std::uint64_t bits = crossed(w);
            if (bits == 0) {
                continue;
            }
            make_room_in_batch();
            std::size_t i = batch_.count;
            auto vertex = static_cast<std::uint32_t>(vertex_count_);
            std::uint64_t* keys = out_.keys.data();
            for (; bits != 0; bits &= bits - 1, ++i, ++vertex) {
                const std::size_t x = w * 64 + static_cast<std::size_t>(std::countr_zero(bits));
                batch_.value_0[i] = static_cast<float>(values_0[x]);
                batch_.value_1[i] = static_cast<float>(values_1[x]);
                batch_.x[i] = static_cast<std::uint32_t>(x);
                batch_.row_and_kind[i] = row_and_kind;
                __builtin_prefetch(needed_0 + x * needed_bytes_);
                __builtin_prefetch(needed_1 + x * needed_bytes_);
                slots[slots_per_voxel * x] = vertex;
                keys[vertex] = first_key + 4 * x;
            }
            batch_.count = i;
            vertex_count_ = vertex;
        }
        out_.counts.edges_visited += static_cast<std::uint32_t>(axis == 0 ? nx - 1 : nx);
        out_.counts.edges_crossed += static_cast<std::uint32_t>(vertex_count_ - vertices_before);
    }

    /// For a word's edges.
    void make_room_in_batch() {
        if (batch_.count + 64 > EdgeBatch::capacity) {
            flush();
        }
        make_room(out_.vertices, vertex_count_ + 64);
        make_room(out_.keys, vertex_count_ + 64);
    }

    /// gradient  Of voxel (x, y) of slice 0 or 1.
    template <class GradientOf>
    void take_gradients(GradientOf gradient) {
        for (std::size_t i = 0; i < batch_.count; ++i) {
            const std::uint32_t kind = batch_.row_and_kind[i], x = batch_.x[i];
            const std::uint32_t y = kind >> edge_kind_bits;
            const std::uint32_t x_step = kind & (along_y | along_z) ? 0 : 1;
            const std::uint32_t y_step = kind & along_y ? 1 : 0;
            batch_.set_gradients(i, gradient(kind & lower_end_above ? 1 : 0, x, y),
                                 gradient(kind & upper_end_above ? 1 : 0, x + x_step, y + y_step));
        }
    }

    /// Makes the vertices of the edges in the batch: the last ones so far.
    void flush() {
        const bool normals = wanted_ != Wanted::measures;
        if (normals && shape_.holds_gradients()) {
            take_gradients([this](std::size_t s, std::size_t x, std::size_t y) {
                return slices_[s]->gradients[y * at(shape_.nx) + x];
            });
        } else if (normals) {
            take_gradients([this](std::size_t s, std::size_t x, std::size_t y) {
                return estimates_[s].at(x, y);
            });
        }
        pxpl5::gp::make_vertices(target_, batch_, frame_, normals,
                                 out_.vertices.data() + (vertex_count_ - batch_.count));
        batch_.count = 0;
    }

    /// Triangles of the cells between rows y and y + 1.
    void make_cells(int y) {
        const std::size_t low = at(y & 1), high = 1 - low;
        out_.counts.cells_visited += static_cast<std::uint32_t>(shape_.nx - 1);
        const std::size_t count =
            find_crossed_cells(target_,
                               {masks_[low][0].data(), masks_[high][0].data(),
                                masks_[low][1].data(), masks_[high][1].data()},
                               at(shape_.nx) - 1, cells_.data());
        if (count == 0) {
            return;
        }
        out_.counts.cells_active += static_cast<std::uint32_t>(count);
        make_room(out_.indices, index_count_ + 3 * max_triangles_per_cell * count);
        if (origins_) {
            make_room(out_.origins, index_count_ / 3 + max_triangles_per_cell * count);
        }
        for (std::size_t done = 0; done < count; ++done) {
            const CellsDone listed = make_triangles(
                target_, std::span(cells_).subspan(done, count - done), vertices_.data(), slots_, y,
                {out_.indices.data() + index_count_,
                 origins_ ? out_.origins.data() + index_count_ / 3 : nullptr});
            index_count_ += listed.corners;
            out_.counts.cells_ambiguous += static_cast<std::uint32_t>(listed.ambiguous_cells);
            done += listed.cells;
            if (done < count) {
                make_cell(static_cast<std::uint8_t>(cells_[done]), cells_[done] >> 8, y);
            }
        }
    }

    /// A cell whose case is unlisted.
    void make_cell(std::uint8_t inside, std::size_t x, int y) {
        const std::uint8_t ambiguous = table_.ambiguous[inside];
        std::uint8_t joined = 0;
        if (ambiguous != 0) {
            ++out_.counts.cells_ambiguous;
            if (table_.decides_faces) {
                joined = decide_faces(inside, ambiguous, x, y);
            }
        }
        const CaseEntry& entry = table_.entry(inside, joined);
        std::uint32_t centre = 0;
        if (entry.ring_size != 0) {
            centre = make_centre(entry, x, y);
        }
        const std::uint8_t* corners = table_.corners.data() + entry.first_corner;
        std::uint32_t* indices = out_.indices.data() + index_count_;
        const auto vertex = [&](std::size_t i) {
            return corners[i] == centre_corner ? centre : vertex_on(corners[i], x, y);
        };
        const std::size_t count = std::size_t{entry.triangle_count} * 3;
        const std::size_t flip = &slots_ == &table_.slots[1] ? 1 : 0;
        for (std::size_t i = 0; i < count; i += 3) {
            indices[i] = vertex(i);
            indices[i + 1] = vertex(i + 1 + flip);
            indices[i + 2] = vertex(i + 2 - flip);
        }
        if (origins_) {
            note_origins({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), inside,
                          joined, 0, 0},
                         entry.triangle_count);
        }
        index_count_ += count;
    }

    /// The vertex on a cell's edge.
    std::uint32_t vertex_on(std::uint8_t edge, std::size_t x, int y) const {
        return vertices_[slots_per_voxel * x + slot_of_edge(edge, at(y & 1))];
    }

    /// Of a cell's triangles, which begin at index_count_.
    void note_origins(Origin origin, std::uint8_t triangle_count) {
        Origin* to = out_.origins.data() + index_count_ / 3;
        for (; origin.triangle < triangle_count; ++origin.triangle) {
            to[origin.triangle] = origin;
        }
    }

    /// On which ambiguous faces the inside corners are joined: where the bilinear interpolation
    /// of the face has its saddle inside. Both products commute, so that both cells at a face
    /// compute the same; ties are separated.
    std::uint8_t decide_faces(std::uint8_t inside, unsigned ambiguous, std::size_t x, int y) const {
        const std::size_t nx = at(shape_.nx), voxel = at(y) * nx + x;
        const auto above = [&](int corner) {
            const std::size_t offset = (corner & 1 ? 1U : 0U) + (corner & 2 ? nx : 0U);
            return static_cast<double>(values_[at(corner >> 2)][voxel + offset]) - frame_.isovalue;
        };
        unsigned joined = 0;
        for (; ambiguous != 0; ambiguous &= ambiguous - 1) {
            const auto corner = face_corners(std::countr_zero(ambiguous));
            const double even = above(corner[0]) * above(corner[2]);
            const double odd = above(corner[1]) * above(corner[3]);
            const bool even_inside = (inside >> corner[0] & 1) != 0;
            if (even_inside ? even > odd : odd > even) {
                joined |= ambiguous & (~ambiguous + 1);
            }
        }
        return static_cast<std::uint8_t>(joined);
    }

    /// The cell's own vertex: the mean of a ring of others, with their mean normal.
    std::uint32_t make_centre(const CaseEntry& entry, std::size_t x, int y) {
        flush();
        glm::dvec3 sum(0);
        glm::vec3 n(0);
        const auto ring = table_.ring_of(entry);
        for (const std::uint8_t edge : ring) {
            const Vertex& vertex = out_.vertices[vertex_on(edge, x, y)];
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
                                           : out_.vertices[vertex_on(ring[0], x, y)].normal;
        centre.unused = 0;
        out_.keys[vertex_count_] =
            4 * (shape_.slice_voxels() * at(slab_) + at(y) * at(shape_.nx) + x) + 3;
        return static_cast<std::uint32_t>(vertex_count_++);
    }

    const VolumeShape& shape_;
    const CaseTable& table_;
    const CaseSlots& slots_;
    SlabMesh& out_;
    SlabFrame frame_;
    std::size_t words_;
    int slab_;
    int next_row_ = 0;
    Wanted wanted_;
    isa::VectorTarget target_;
    bool origins_;
    std::array<const HeldSlice*, 2> slices_{};
    std::array<const T*, 2> values_{};
    std::array<VoxelGradients<T>, 2> estimates_;  ///< Only if gradients are not held.
    std::array<std::array<std::vector<std::uint64_t>, 2>, 2> masks_;  ///< [parity][slice]
    std::array<std::array<RowSide, 2>, 2> sides_{};                   ///< [parity][slice]
    std::array<const std::byte*, 2> needed_{};  ///< Slices that gradients come from.
    std::size_t needed_bytes_ = 0;              ///< Per voxel.
    std::vector<std::uint32_t> vertices_;       ///< Of two rows, by slot.
    std::vector<CrossedCell> cells_;            ///< Of a row.
    EdgeBatch batch_;
    std::size_t vertex_count_ = 0, index_count_ = 0;
    std::size_t upper_count_ = 0;  ///< Vertices in the upper slice, which the next slab owns.
};

}  // namespace pxpl5::gp
