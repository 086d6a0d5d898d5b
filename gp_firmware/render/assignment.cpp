#include "gp_firmware/render/assignment.hpp"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace pxpl5::gp {

namespace {

std::vector<std::uint16_t> round_robin(std::size_t region_count, std::size_t renderer_count) {
    std::vector<std::uint16_t> assignment(region_count);
    for (std::size_t region = 0; region < region_count; ++region) {
        assignment[region] = static_cast<std::uint16_t>(region % renderer_count);
    }
    return assignment;
}

}  // namespace

std::vector<std::uint16_t> assign_regions(std::size_t region_count, std::size_t renderer_count,
                                          std::span<const std::uint64_t> costs, std::size_t most) {
    assert(renderer_count > 0 && (region_count + renderer_count - 1) / renderer_count <= most);
    if (costs.size() != region_count) {
        return round_robin(region_count, renderer_count);
    }
    std::vector<std::size_t> dearest_first(region_count);
    std::iota(dearest_first.begin(), dearest_first.end(), std::size_t{0});
    std::ranges::stable_sort(dearest_first, std::greater{},
                             [&](std::size_t region) { return costs[region]; });

    std::vector<std::uint16_t> assignment(region_count);
    std::vector<std::uint64_t> load(renderer_count, 0), regions(renderer_count, 0);
    for (const std::size_t region : dearest_first) {
        // Regions of cost 0 are spread too, because their cost may rise.
        std::size_t best = 0;
        for (std::size_t r = 1; r < renderer_count; ++r) {
            if (regions[best] == most ||
                (regions[r] < most &&
                 std::pair(load[r], regions[r]) < std::pair(load[best], regions[best]))) {
                best = r;
            }
        }
        assignment[region] = static_cast<std::uint16_t>(best);
        load[best] += costs[region];
        ++regions[best];
    }
    return assignment;
}

}  // namespace pxpl5::gp
