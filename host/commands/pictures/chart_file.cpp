#include "host/commands/pictures/chart_file.hpp"

#include <cstdint>

namespace pxpl5::host {

void write_chart_file(Session& session, const ChartFile& chart, const std::string& path) {
    const MarkColor& c = chart.paper;
    const auto paper = static_cast<std::uint32_t>(c.r | c.g << 8 | c.b << 16) | 0xff00'0000U;
    const auto pixels =
        static_cast<std::size_t>(chart.size.width) * static_cast<std::size_t>(chart.size.height);
    const Picture picture{chart.size.width, chart.size.height,
                          std::vector<std::uint32_t>(pixels, paper)};
    PictureExtras extras;
    extras.description = chart.description;
    extras.marks = chart.marks;
    session.exports.pictures({&picture, 1}, path, extras);
}

}  // namespace pxpl5::host
