// Slots: the places of the vertices on the edges of a row of cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pxpl5::gp {

struct CaseTable;

// Each voxel x of a row of cells has eight slots: for the edges that leave voxel x of the lower row
// along y, and for those that leave voxel x of both rows along z and x. A cell uses the slots of
// its own voxel and the first four of the next voxel. Rows y and y - 1 alternate in the slots with
// a parity, so that vertices that two rows of cells share keep their slots.
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

/// Returns the slot of a cell's edge 0..11, counted from the first slot of its voxel.
/// parity  Parity of the cell's lower row.
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

/// The form of a CaseTable that a walk reads: the slots of each case's corners, triangle by
/// triangle.
struct CaseSlots {
    using Corners = std::array<std::uint8_t, max_listed_corners>;
    /// Indexed by the parity of the cells' lower row and by the set of inside corners.
    std::array<std::array<Corners, 256>, 2> corners{};
    /// Number of corners; `unlisted` if a case has several entries, a center or too many corners.
    std::array<std::uint8_t, 256> corner_count{};
    std::array<std::uint8_t, 256> has_ambiguous_face{};  ///< 0 or 1.
};
inline constexpr std::uint8_t unlisted = 255;

/// flip  Turns all triangles over.
CaseSlots case_slots(const CaseTable& table, bool flip);

}  // namespace pxpl5::gp
