// The vertices of one slab's mesh, row by row.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gp_firmware/surface/case_slots.hpp"
#include "gp_firmware/surface/edge_batch.hpp"
#include "gp_firmware/surface/make_room.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/surface/row_masks.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "gp_firmware/volume/typed.hpp"
#include "gp_firmware/volume/voxel_gradient.hpp"

namespace pxpl5::gp {

/// Outputs of a walk besides positions and triangles.
enum class Wanted : std::uint8_t { measures, mesh, mesh_with_origins };

/// Makes vertices on the crossed edges of a slab. Remembers the vertices of two rows only, in slots
/// (case_slots.hpp).
template <class T>
class SlabVertices {
  public:
    SlabVertices(const SliceStore& store, int slab, double isovalue, SlabMesh& out, bool normals,
                 VectorTarget target)
        : shape_(store.shape()), out_(out), slab_(slab), normals_(normals), target_(target) {
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
        slots_.resize(slots_per_voxel * at(shape_.nx));
    }

    /// Makes the vertices on the edges of row y, and on those between rows y and y - 1.
    void make_row(int y, const RowMasks& masks) {
        const std::size_t row = at(y & 1);
        for (const std::size_t s : {0U, 1U}) {
            if (masks.side(row, s) == RowSide::mixed) {
                const std::uint64_t* m = masks.mask(row, s);
                make_edges({y, x_slot(row, s), along_slice(s)}, masks.word_count(),
                           [&](std::size_t w) {
                               const std::uint64_t right = m[w] >> 1 | m[w + 1] << 63;
                               return (m[w] ^ right) & cells_in_word(w);
                           });
            }
        }
        if (masks.side(row, 0) == RowSide::mixed || masks.side(row, 0) != masks.side(row, 1)) {
            make_edges({y, z_slot(row), along_z | upper_end_above}, masks.word_count(),
                       difference(masks.mask(row, 0), masks.mask(row, 1)));
        }
        for (const std::size_t s : {0U, 1U}) {
            const RowSide side = masks.side(0, s);
            if (y > 0 && (side == RowSide::mixed || side != masks.side(1, s))) {
                make_edges({y - 1, y_slot(s), along_y | along_slice(s)}, masks.word_count(),
                           difference(masks.mask(0, s), masks.mask(1, s)));
            }
        }
    }

    /// Makes the vertex in the center of cell (x, y): the mean of the vertices on `ring`, a list of
    /// edges, with their mean normal.
    std::uint32_t make_center(std::span<const std::uint8_t> ring, std::size_t x, int y) {
        flush();
        glm::dvec3 sum(0);
        glm::vec3 n(0);
        for (const std::uint8_t edge : ring) {
            const Vertex& vertex = out_.vertices[vertex_on(edge, x, y)];
            sum += glm::dvec3(vertex.p_voxel);
            n += glm::vec3(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
        }
        const float length_squared = n.x * n.x + n.y * n.y + n.z * n.z;
        make_room(out_.vertices, vertex_count_ + 1);
        make_room(out_.keys, vertex_count_ + 1);
        Vertex& center = out_.vertices[vertex_count_];
        center.p_voxel = glm::vec3(sum / static_cast<double>(ring.size()));
        // Normals that cancel out give no direction. Then the first of the ring serves.
        center.normal = length_squared > 0 ? pack_normal(n, length_squared)
                                           : out_.vertices[vertex_on(ring[0], x, y)].normal;
        center.unused = 0;
        out_.keys[vertex_count_] =
            4 * (shape_.slice_voxels() * at(slab_) + at(y) * at(shape_.nx) + x) + 3;
        return static_cast<std::uint32_t>(vertex_count_++);
    }

    /// Returns the vertex on an edge of cell (x, y).
    std::uint32_t vertex_on(std::uint8_t edge, std::size_t x, int y) const {
        return slots_[slots_per_voxel * x + slot_of_edge(edge, at(y & 1))];
    }

    /// Ends the lists of vertices and keys.
    void finish() {
        flush();
        out_.vertices.resize(vertex_count_);
        out_.keys.resize(vertex_count_);
        const bool top = slab_ == shape_.slab_count() - 1;
        out_.counts.vertices = static_cast<std::uint32_t>(vertex_count_ - (top ? 0 : upper_count_));
    }

    const std::uint32_t* slots() const { return slots_.data(); }
    const T* values(std::size_t slice) const { return values_[slice]; }

  private:
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }

    /// Sets the source of the gradients of slice 0 or 1.
    void take_source(const SliceStore& store, int s) {
        const HeldSlice& slice = *slices_[at(s)];
        if (shape_.holds_gradients()) {
            needed_[at(s)] = reinterpret_cast<const std::byte*>(slice.gradients.data());
            needed_bytes_ = normals_ ? sizeof(Gradient) : 0;
        } else {
            const SliceNeighbors slices = store.neighbors(slab_ + s);
            estimates_[at(s)] = VoxelGradients<T>(shape_, slices);
            // The walk reads the two slices of the slab anyway, so only the third is fetched early.
            needed_[at(s)] = (s == 0 ? slices.below : slices.above).data();
            needed_bytes_ = normals_ ? sizeof(T) : 0;
        }
    }

    static std::uint32_t along_slice(std::size_t s) {
        return s == 0 ? 0U : lower_end_above | upper_end_above;
    }

    static auto difference(const std::uint64_t* a, const std::uint64_t* b) {
        return [a, b](std::size_t w) { return a[w] ^ b[w]; };
    }

    /// Returns the bits of a word's cells. A row has one cell less than voxels.
    std::uint64_t cells_in_word(std::size_t w) const {
        const std::size_t rest = static_cast<std::size_t>(shape_.nx) - 1 - w * 64;
        return rest >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << rest) - 1;
    }

    /// Parallel edges of a row.
    struct EdgeRow {
        int y = 0;  ///< Row of the lower ends.
        std::size_t slot = 0;
        std::uint32_t kind = 0;  ///< EdgeKind.
    };

    /// Adds the crossed edges of a row to the batch, and begins to fetch the sources of their
    /// gradients. These are seldom in the cache; the edges of a batch wait for them together.
    /// crossed  Returns the crossed edges of a word.
    template <class Crossed>
    void make_edges(const EdgeRow& row, std::size_t word_count, Crossed crossed) {
        const std::size_t nx = at(shape_.nx), voxel = at(row.y) * nx;
        const std::size_t lower = row.kind & lower_end_above ? 1 : 0;
        const std::size_t upper = row.kind & upper_end_above ? 1 : 0;
        const std::size_t axis = row.kind & along_z ? 2 : row.kind & along_y ? 1 : 0;
        const std::size_t step = axis == 0 ? 1 : axis == 1 ? nx : 0;  // Within the slice.
        const T* values_0 = values_[lower] + voxel;
        const T* values_1 = values_[upper] + voxel + step;
        const std::size_t needed_bytes = needed_bytes_;  // `keys` may alias the member.
        const std::byte* needed_0 = needed_[lower] + voxel * needed_bytes;
        const std::byte* needed_1 = needed_[upper] + (voxel + step) * needed_bytes;
        const std::uint32_t row_and_kind =
            static_cast<std::uint32_t>(row.y) << edge_kind_bits | row.kind;
        const std::uint64_t first_key =
            4 * (shape_.slice_voxels() * (at(slab_) + lower) + voxel) + axis;
        std::uint32_t* slots = slots_.data() + row.slot;
        const std::size_t vertices_before = vertex_count_;
        for (std::size_t w = 0; w < word_count; ++w) {
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
                __builtin_prefetch(needed_0 + x * needed_bytes);
                __builtin_prefetch(needed_1 + x * needed_bytes);
                slots[slots_per_voxel * x] = vertex;
                keys[vertex] = first_key + 4 * x;
            }
            batch_.count = i;
            vertex_count_ = vertex;
        }
        if ((row.kind & lower_end_above) != 0) {
            upper_count_ += vertex_count_ - vertices_before;
        }
        out_.counts.edges_visited += static_cast<std::uint32_t>(axis == 0 ? nx - 1 : nx);
        out_.counts.edges_crossed += static_cast<std::uint32_t>(vertex_count_ - vertices_before);
    }

    /// Makes room for the edges of one word.
    void make_room_in_batch() {
        if (batch_.count + 64 > EdgeBatch::capacity) {
            flush();
        }
        make_room(out_.vertices, vertex_count_ + 64);
        make_room(out_.keys, vertex_count_ + 64);
    }

    /// gradient  Returns the gradient at voxel (x, y) of slice 0 or 1.
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

    /// Makes the vertices of the edges that are still in the batch.
    void flush() {
        if (normals_ && shape_.holds_gradients()) {
            take_gradients([this](std::size_t s, std::size_t x, std::size_t y) {
                return slices_[s]->gradients[y * at(shape_.nx) + x];
            });
        } else if (normals_ && shape_.gradient == GradientKernel::smooth) {
            take_gradients([this](std::size_t s, std::size_t x, std::size_t y) {
                return estimates_[s].smooth(x, y);
            });
        } else if (normals_) {
            take_gradients([this](std::size_t s, std::size_t x, std::size_t y) {
                return estimates_[s].central(x, y);
            });
        }
        pxpl5::gp::make_vertices(target_, batch_, frame_, normals_,
                                 out_.vertices.data() + (vertex_count_ - batch_.count));
        batch_.count = 0;
    }

    const VolumeShape& shape_;
    SlabMesh& out_;
    SlabFrame frame_;
    int slab_;
    bool normals_;
    VectorTarget target_;
    std::array<const HeldSlice*, 2> slices_{};
    std::array<const T*, 2> values_{};
    std::array<VoxelGradients<T>, 2> estimates_;  ///< Used if gradients are not stored.
    std::array<const std::byte*, 2> needed_{};    ///< Sources of the gradients.
    std::size_t needed_bytes_ = 0;                ///< Bytes per voxel of these sources.
    std::vector<std::uint32_t> slots_;            ///< Vertices of two rows.
    EdgeBatch batch_;
    std::size_t vertex_count_ = 0;
    std::size_t upper_count_ = 0;  ///< Vertices in the upper slice, which the next slab counts.
};

}  // namespace pxpl5::gp
