// The walk of marching cubes through the cells of one slab: masks, vertices, triangles.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/cell_row.hpp"
#include "gp_firmware/surface/make_room.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/surface/row_masks.hpp"
#include "gp_firmware/surface/slab_vertices.hpp"
#include "gp_firmware/volume/slice_store.hpp"

namespace pxpl5::gp {

inline constexpr std::size_t max_triangles_per_cell = 12;

/// Walks up the rows of a slab and makes their triangles.
template <class T>
class SlabWalk {
  public:
    SlabWalk(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
             SlabMesh& out, Wanted wanted, VectorTarget target)
        : shape_(store.shape()),
          isovalue_(isovalue),
          table_(table),
          slots_(table.slots[mirrors(shape_) ? 1 : 0]),
          out_(out),
          target_(target),
          origins_(wanted == Wanted::mesh_with_origins),
          masks_(store, slab, isovalue),
          vertices_(store, slab, isovalue, out, wanted != Wanted::measures, target) {
        cells_.resize(at(shape_.nx));
    }

    /// Walks until `triangles` more are made. Returns false when all rows are done.
    bool advance(std::size_t triangles) {
        const std::size_t enough = index_count_ / 3 + triangles;
        for (; next_row_ < shape_.ny; ++next_row_) {
            if (index_count_ / 3 >= enough) {
                return true;
            }
            const int y = next_row_;
            masks_.classify(y);
            vertices_.make_row(y, masks_);
            if (y == 0) {
                continue;
            }
            if (masks_.may_cross()) {
                make_cells(y - 1);
            } else {
                ++out_.counts.rows_skipped;
            }
        }
        vertices_.finish();
        out_.indices.resize(index_count_);
        out_.origins.resize(origins_ ? index_count_ / 3 : 0);
        out_.counts.triangles = static_cast<std::uint32_t>(index_count_ / 3);
        return false;
    }

  private:
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }

    /// Returns whether voxel_to_patient mirrors, so that triangles must be turned over.
    static bool mirrors(const VolumeShape& shape) {
        return glm::determinant(glm::dmat3(shape.voxel_to_patient)) < 0;
    }

    /// Makes the triangles of the cells between rows y and y + 1.
    void make_cells(int y) {
        out_.counts.cells_visited += static_cast<std::uint32_t>(shape_.nx - 1);
        const std::size_t count = find_crossed_cells(target_, masks_.cells_above(at(y & 1)),
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
            const CellsDone listed =
                make_triangles(target_, std::span(cells_).subspan(done, count - done),
                               vertices_.slots(), slots_, y,
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

    /// Makes the triangles of a cell whose case is not listed in CaseSlots.
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
        std::uint32_t center = 0;
        if (entry.ring_size != 0) {
            center = vertices_.make_center(table_.ring_of(entry), x, y);
        }
        const std::uint8_t* corners = table_.corners.data() + entry.first_corner;
        std::uint32_t* indices = out_.indices.data() + index_count_;
        const auto vertex = [&](std::size_t i) {
            return corners[i] == center_corner ? center : vertices_.vertex_on(corners[i], x, y);
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

    /// Writes the origins of a cell's triangles, the first of which begins at index_count_.
    void note_origins(Origin origin, std::uint8_t triangle_count) {
        Origin* to = out_.origins.data() + index_count_ / 3;
        for (; origin.triangle < triangle_count; ++origin.triangle) {
            to[origin.triangle] = origin;
        }
    }

    /// Returns the ambiguous faces on which the inside corners are joined: those whose bilinear
    /// interpolation has its saddle inside. Both products commute, so that both cells at a face
    /// compute the same. Ties are separated.
    std::uint8_t decide_faces(std::uint8_t inside, unsigned ambiguous, std::size_t x, int y) const {
        const std::size_t nx = at(shape_.nx), voxel = at(y) * nx + x;
        const auto above = [&](int corner) {
            const std::size_t offset = (corner & 1 ? 1U : 0U) + (corner & 2 ? nx : 0U);
            return static_cast<double>(vertices_.values(at(corner >> 2))[voxel + offset]) -
                   isovalue_;
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

    const VolumeShape& shape_;
    double isovalue_;
    const CaseTable& table_;
    const CaseSlots& slots_;
    SlabMesh& out_;
    VectorTarget target_;
    bool origins_;
    RowMasks masks_;
    SlabVertices<T> vertices_;
    std::vector<CrossedCell> cells_;  ///< Crossed cells of a row.
    std::size_t index_count_ = 0;
    int next_row_ = 0;
};

}  // namespace pxpl5::gp
