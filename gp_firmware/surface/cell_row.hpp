// A row of cells: which of them the surface crosses, and the triangles that they hold.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gp_firmware/surface/case_slots.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// The masks of a row of cells: of rows y and y + 1 in the lower slice, then in the upper. Each has
/// a word more than the row.
using CellMasks = std::array<const std::uint64_t*, 4>;

/// A crossed cell: x << 8 | inside corners.
using CrossedCell = std::uint32_t;

/// Lists the crossed cells of a row, ascending.
/// cell_count  One less than voxels.
/// out         Room for cell_count.
/// Returns     How many there are.
std::size_t find_crossed_cells(isa::VectorTarget target, const CellMasks& masks,
                               std::size_t cell_count, CrossedCell* out);

/// Whole vectors are written: what lies beyond a cell's own the next overwrites.
inline constexpr std::size_t max_listed_triangles = 8;

/// Where triangles go.
struct TriangleRoom {
    std::uint32_t* indices;  ///< For max_listed_corners of each cell.
    Origin* origins;         ///< For max_listed_triangles of each; null if nobody asked.
};

/// What make_triangles() has done.
struct CellsDone {
    std::size_t cells = 0, ambiguous_cells = 0, corners = 0;
};

/// Writes the triangles of crossed cells between rows y and y + 1, up to the first cell whose case
/// is unlisted.
/// vertices  The row's slots.
CellsDone make_triangles(isa::VectorTarget target, std::span<const CrossedCell> cells,
                         const std::uint32_t* vertices, const CaseSlots& slots, int y,
                         TriangleRoom room);

}  // namespace pxpl5::gp
