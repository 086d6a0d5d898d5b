#include "host/timing/plot.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/timing/plot_parts.hpp"

namespace pxpl5::host::timing {

std::string svg_of(std::span<const Plot> plots, std::size_t columns) {
    if (plots.empty() || columns == 0) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("a picture cannot be drawn of {} plots in {} columns",
                                       plots.size(), columns));
    }
    std::vector<Svg> parts;
    std::vector<double> widths(std::min(columns, plots.size()));
    for (const Plot& plot : plots) {
        parts.push_back(std::visit([](const auto& kind) { return drawn(kind); }, plot));
        double& width = widths[(parts.size() - 1) % columns];
        width = std::max(width, parts.back().width);
    }
    Svg all;
    for (std::size_t first = 0; first < parts.size(); first += columns) {
        double x = 0, height = 0;
        for (std::size_t i = first; i < std::min(first + columns, parts.size()); ++i) {
            all.place(parts[i], {x, all.height});
            x += widths[i - first];
            height = std::max(height, parts[i].height);
        }
        all.width = std::max(all.width, x);
        all.height += height;
    }
    return all.document();
}

}  // namespace pxpl5::host::timing
