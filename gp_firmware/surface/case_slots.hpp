// Where a row of cells finds the vertices on its edges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pxpl5::gp {

struct CaseTable;

// The vertices on the edges between two rows of voxels, voxel by voxel and slot by slot: of the
// edges that leave voxel x of the lower row along y, and of both rows along z and x. A cell's are
// those of its own voxel and the first four of the next. Rows y and y - 1 take turns in the slots
// with a parity, so that what two rows of cells share stays where it is.
inline constexpr std::size_t slots_per_voxel = 8;
constexpr std::size_t y_slot(std::size_t slice) {
    return slice;
}
constexpr std::size_t z_slot(std::size_t parity) {
    return 2 + parity;
}
constexpr std::size_t x_slot(std::size_t parity, std::size_t slice) {
    return 4 + 2 * parity + slice;
}

/// Slot of a cell's edge 0..11, from the first slot of its voxel.
/// parity  Of the cell's lower row.
constexpr std::size_t slot_of_edge(std::size_t edge, std::size_t parity) {
    const std::size_t i = edge & 1, j = edge >> 1 & 1;
    switch (edge >> 2) {
        case 0:
            return x_slot(i ^ parity, j);
        case 1:
            return i * slots_per_voxel + y_slot(j);
        default:
            return i * slots_per_voxel + z_slot(j ^ parity);
    }
}

inline constexpr std::size_t max_listed_corners = 16;

/// A CaseTable as a walk reads it: the slots of each case's corners, triangle by triangle.
struct CaseSlots {
    using Corners = std::array<std::uint8_t, max_listed_corners>;
    /// By parity of the cells' lower row, and inside corners.
    std::array<std::array<Corners, 256>, 2> corners{};
    /// Corners; unlisted where a case has several entries, a centre, or too many corners.
    std::array<std::uint8_t, 256> corner_count{};
    std::array<std::uint8_t, 256> has_ambiguous_face{};  ///< 0 or 1.
};
inline constexpr std::uint8_t unlisted = 255;

/// flip  Whether triangles are turned over.
CaseSlots case_slots(const CaseTable& table, bool flip);

}  // namespace pxpl5::gp
