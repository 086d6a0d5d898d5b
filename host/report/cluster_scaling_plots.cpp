#include "host/report/cluster_scaling.hpp"

namespace pxpl5::host::report {

namespace {

constexpr std::size_t ideal_color = 7, solid_colors = 5;

LinePlot plot_of(const ClusterScaling& scaling, bool is_weak, ClusterRate ClusterPoint::*rate,
                 const std::string& title) {
    LinePlot plot;
    plot.title = title;
    plot.note = is_weak ? "Circle: the last point with at least half the rate of one computer."
                        : "Circle: doubling from here gains less than 5 %.";
    plot.x = {"computers", PlotScale::log2};
    plot.y = {"rate, relative to one computer", PlotScale::log2};
    PlotLine ideal{is_weak ? "constant" : "linear", {}, ideal_color, true, {}};
    for (std::size_t i = 0; i < scaling.rows.size(); ++i) {
        const ClusterSeries& series = is_weak ? scaling.rows[i].weak : scaling.rows[i].strong;
        const std::vector<double> relative = series.relative(rate);
        PlotLine line{scaling.rows[i].name, {}, i % solid_colors, i >= solid_colors, {}};
        ideal.points.clear();
        for (std::size_t n = 0; n < relative.size(); ++n) {
            const double computers = series.points[n].computers;
            line.points.push_back({computers, relative[n]});
            ideal.points.push_back({computers, is_weak ? 1 : computers});
        }
        line.ringed = end_of_growth(relative, is_weak);
        plot.lines.push_back(line);
    }
    plot.lines.push_back(ideal);
    return plot;
}

}  // namespace

std::vector<Plot> plots_of(const ClusterScaling& scaling) {
    return {
        plot_of(scaling, false, &ClusterPoint::frames, "Frames, the same volume"),
        plot_of(scaling, false, &ClusterPoint::thresholds, "Thresholds, the same volume"),
        plot_of(scaling, true, &ClusterPoint::frames, "Frames, slabs grow with computers"),
        plot_of(scaling, true, &ClusterPoint::thresholds, "Thresholds, slabs grow with computers")};
}

}  // namespace pxpl5::host::report
