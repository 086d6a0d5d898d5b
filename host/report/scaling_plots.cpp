#include <fmt/format.h>

#include <algorithm>

#include "host/report/scaling.hpp"

namespace pxpl5::host::report {

namespace {

constexpr std::size_t gray = 7, row_colors = 5;
using SpeedUp = std::vector<double> (ScalingSeries::*)() const;

/// The first five rows are drawn solid; those after them, which stand for the same, dashed.
PlotLine line_of(const ScalingRow& row, const ScalingSeries& series, SpeedUp which,
                 std::size_t index) {
    PlotLine line{row.name, {}, index % row_colors, index >= row_colors, {}};
    const std::vector<double> speed_up = (series.*which)();
    for (std::size_t i = 0; i < speed_up.size(); ++i) {
        line.points.push_back({static_cast<double>(series.points[i].count), speed_up[i]});
    }
    line.ringed = saturation(speed_up);
    return line;
}

LinePlot plot_of(const ScalingReport& report, ScalingSeries ScalingRow::*series, SpeedUp which,
                 const std::string& title, const std::string& nodes) {
    LinePlot plot;
    plot.title = title;
    plot.x = {nodes, PlotScale::log2};
    plot.y = {"times as fast as with one", PlotScale::log2};
    for (std::size_t i = 0; i < report.rows.size(); ++i) {
        plot.lines.push_back(line_of(report.rows[i], report.rows[i].*series, which, i));
    }
    PlotLine ideal{"linear", {}, gray, true, {}};
    for (const ChartPoint& point : plot.lines.at(0).points) {
        ideal.points.push_back({point.x, point.x});
    }
    plot.lines.push_back(ideal);
    if (std::ranges::any_of(plot.lines,
                            [](const PlotLine& line) { return line.ringed.has_value(); })) {
        plot.note =
            fmt::format("Circle: doubling from here gains less than {:.0f} %.", least_gain * 100);
    }
    return plot;
}

}  // namespace

std::vector<Plot> plots_of(const ScalingReport& report) {
    const std::string beside_gps = fmt::format(", {} Renderers", report.renderers);
    return {plot_of(report, &ScalingRow::gps, &ScalingSeries::build_speed_up,
                    "Surface built, by GPs" + beside_gps, "GPs"),
            plot_of(report, &ScalingRow::gps, &ScalingSeries::frames_speed_up,
                    "Frames shown, by GPs" + beside_gps, "GPs"),
            plot_of(report, &ScalingRow::renderers, &ScalingSeries::frames_speed_up,
                    fmt::format("Frames shown, by Renderers, {} GPs", report.gps), "Renderers")};
}

}  // namespace pxpl5::host::report
