#include "host/timing/counts/work.hpp"

#include <numeric>

#include "ringbus/rules/regions.hpp"

namespace pxpl5::host::timing {

std::uint64_t PartWork::cycles() const {
    return std::accumulate(
        classes.begin(), classes.end(), std::uint64_t{0},
        [](std::uint64_t sum, const ClassCounts& counts) { return sum + counts.cycles; });
}

std::size_t FrameWork::regions() const {
    return region_count(width, height, views);
}

std::vector<std::uint64_t> FrameWork::region_cycles() const {
    std::vector<std::uint64_t> cycles(regions());
    for (const PartWork& part : parts) {
        cycles.at(part.region) += part.cycles();
    }
    return cycles;
}

}  // namespace pxpl5::host::timing
