// Assignment: which Renderer draws which region. Done by the Master GP, for all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace pxpl5::gp {

inline constexpr std::size_t max_assigned = std::numeric_limits<std::size_t>::max();

/// Gives each region to a Renderer.
///
/// costs  Of the previous frame, by region, in any unit; empty, or of another length, means not
///        known: the regions then go round-robin.
/// most   Regions that a Renderer takes; renderer_count * most are enough for all.
/// Returns  The index of the Renderer for each region. With costs: the dearest region first, each
///          to the Renderer with the least to do that takes more; ties go to the lower index.
/// Source  Graham 1969, longest processing time first.
std::vector<std::uint16_t> assign_regions(std::size_t region_count, std::size_t renderer_count,
                                          std::span<const std::uint64_t> costs,
                                          std::size_t most = max_assigned);

}  // namespace pxpl5::gp
