#include "host/session/transfer/frame_report.hpp"

#include <algorithm>

#include "ringbus/rules/regions.hpp"

namespace pxpl5::host {

void add_pass(const WholeFrame& done, FrameReport& report) {
    const auto regions_across = [](int px) {
        return static_cast<int>(region_count(static_cast<std::uint32_t>(px), 1, 1));
    };
    report.frame = done.frame;
    report.moved_mm = std::max(report.moved_mm, done.moved_mm);
    report.instructions += static_cast<std::int64_t>(done.instructions);
    report.region_columns = regions_across(done.view.width);
    report.region_rows = regions_across(done.view.height) * done.views;
    report.region_renderers = done.region_renderers;
    report.region_cycles.resize(done.region_cycles.size());
    for (std::size_t region = 0; region < done.region_cycles.size(); ++region) {
        const std::uint64_t cycles = done.region_cycles[region];
        report.region_cycles[region] += cycles;
        report.renderer_cycles += static_cast<std::int64_t>(cycles);
    }
}

}  // namespace pxpl5::host
