#include "host/chart/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"

namespace pxpl5::host {

void refuse_plot(const std::string& plot, const std::string& reason) {
    throw RequestError(ExitCode::bad_data,
                       fmt::format("plot '{}' cannot be drawn: {}", plot, reason));
}

void check_number(const std::string& plot, const std::string& where, double value) {
    if (!std::isfinite(value)) {
        refuse_plot(plot, fmt::format("{} is {}, must be a finite number", where, value));
    }
}

Chart chart_of(std::span<const Plot> plots, std::size_t columns) {
    if (plots.empty() || columns == 0) {
        throw RequestError(ExitCode::bad_data, fmt::format("cannot draw {} plots in {} columns",
                                                           plots.size(), columns));
    }
    std::vector<Chart> parts;
    std::vector<double> widths(std::min(columns, plots.size()));
    for (const Plot& plot : plots) {
        parts.push_back(std::visit([](const auto& kind) { return drawn(kind); }, plot));
        double& width = widths[(parts.size() - 1) % columns];
        width = std::max(width, parts.back().width);
    }
    Chart all;
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
    return all;
}

}  // namespace pxpl5::host
