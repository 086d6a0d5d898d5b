// Assignment of regions to Renderers. Only the Master GP (GP 0) computes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace pxpl5::gp {

inline constexpr std::size_t max_assigned = std::numeric_limits<std::size_t>::max();

/// Assigns each region to a Renderer.
///
/// costs  Costs of the regions in the previous frame, in any unit. If the list is empty or has
///        another length, the costs are unknown, and the assignment is round-robin.
/// most   Maximum of regions per Renderer; renderer_count * most suffices for all regions.
/// Returns  The index of the Renderer of each region. With costs, the most expensive region comes
///          first, and each region goes to the Renderer with the least load that has room. Ties go
///          to the lower index.
/// Source  Graham 1969, longest processing time first.
std::vector<std::uint16_t> assign_regions(std::size_t region_count, std::size_t renderer_count,
                                          std::span<const std::uint64_t> costs,
                                          std::size_t most = max_assigned);

}  // namespace pxpl5::gp
