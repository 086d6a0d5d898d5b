// Which of a voxel's neighbors hang together without it.
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>

namespace pxpl5::host {

enum class Side : std::uint8_t { inside, outside };

/// The 6 neighbors across faces, then the 12 across faces' diagonals.
inline constexpr std::size_t neighbor_count = 18;
inline constexpr std::uint32_t face_neighbors = 63;

const std::array<std::array<int, 3>, neighbor_count>& neighbor_steps();

/// Neighbors that a voxel of that side is joined to: inside the 6, outside all 18.
constexpr std::uint32_t joining_links(Side side) {
    return side == Side::inside ? face_neighbors : (1U << neighbor_count) - 1;
}

/// By a set of neighbors of one side, bit k for neighbor k: whether those that join are all in
/// one group, by steps within the set.
using LinkTable = std::bitset<std::size_t{1} << neighbor_count>;

/// Made at first use.
const LinkTable& link_table(Side side);

}  // namespace pxpl5::host
