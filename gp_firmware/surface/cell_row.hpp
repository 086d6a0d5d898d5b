// A row of cells: the cells that the surface crosses, and their triangles.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gp_firmware/surface/case_slots.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// The masks of a row of cells: rows y and y + 1 of the lower slice, then of the upper slice. Each
/// mask has one word more than the row.
using CellMasks = std::array<const std::uint64_t*, 4>;

/// A crossed cell: x << 8 | inside corners.
using CrossedCell = std::uint32_t;

/// Lists the crossed cells of a row, ascending.
/// cell_count  One less than voxels.
/// out         Room for cell_count.
/// Returns     The number of crossed cells.
std::size_t find_crossed_cells(VectorTarget target, const CellMasks& masks, std::size_t cell_count,
                               CrossedCell* out);

/// make_triangles() writes whole vectors. The next cell overwrites the excess.
inline constexpr std::size_t max_listed_triangles = 8;

/// The output of make_triangles().
struct TriangleRoom {
    std::uint32_t* indices;  ///< Room for max_listed_corners per cell.
    Origin* origins;         ///< Room for max_listed_triangles per cell; null without origins.
};

/// The numbers of cells and corners that make_triangles() has finished.
struct CellsDone {
    std::size_t cells = 0, ambiguous_cells = 0, corners = 0;
};

/// Writes the triangles of crossed cells between rows y and y + 1. Stops before the first cell
/// whose case is unlisted. vertices  The slots of the row.
CellsDone make_triangles(VectorTarget target, std::span<const CrossedCell> cells,
                         const std::uint32_t* vertices, const CaseSlots& slots, int y,
                         TriangleRoom room);

}  // namespace pxpl5::gp
