#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "host/chart/plot.hpp"

namespace pxpl5::host {

namespace {

constexpr double area_width = 440, area_height = 280, disc_radius = 3, ring_radius = 7, line_px = 2;

struct Range {
    double low = std::numeric_limits<double>::infinity(),
           high = -std::numeric_limits<double>::infinity();
};

void check(const LinePlot& plot) {
    if (plot.lines.empty()) {
        refuse_plot(plot.title, "it has no lines");
    }
    for (const PlotLine& line : plot.lines) {
        if (line.points.empty()) {
            refuse_plot(plot.title, fmt::format("line '{}' has no points", line.name));
        }
        if (line.ringed && *line.ringed >= line.points.size()) {
            refuse_plot(plot.title, fmt::format("line '{}' has {} points, but point {} is ringed",
                                                line.name, line.points.size(), *line.ringed));
        }
    }
}

/// Returns the range of one coordinate of all points.
Range range_of(const LinePlot& plot, const PlotAxis& axis, double ChartPoint::*coordinate) {
    Range range;
    for (const PlotLine& line : plot.lines) {
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            const double value = line.points[i].*coordinate;
            const std::string where =
                fmt::format("point {} of line '{}' at {}", i, line.name, axis.label);
            check_number(plot.title, where, value);
            if (axis.scale == PlotScale::log2 && value <= 0) {
                refuse_plot(plot.title, fmt::format("{} is {}, not > 0 as an axis of octaves needs",
                                                    where, value));
            }
            range = {std::min(range.low, value), std::max(range.high, value)};
        }
    }
    return range;
}

ChartAxis axis_for(const PlotAxis& axis, const Range& range) {
    if (axis.scale == PlotScale::log2) {
        return octave_axis(range.low, range.high, most_ticks);
    }
    return range.low >= 0 ? axis_from_zero(range.high, most_ticks)
                          : linear_axis(range.low, std::max(range.high, 0.0), most_ticks);
}

void draw_line(Chart& chart, const ChartBox& box, const ChartAxis& x, const ChartAxis& y,
               const PlotLine& line) {
    std::vector<ChartPoint> places;
    for (const ChartPoint& point : line.points) {
        places.push_back(box.at(x, point.x, y, point.y));
    }
    const MarkColor color = series_color(line.color);
    if (line.dashed) {
        chart.dashed(places, color, line_px);
    } else {
        chart.line(places, color, line_px);
        for (const ChartPoint& place : places) {
            chart.disc(place, disc_radius, color);
        }
    }
    if (line.ringed) {
        chart.ring(places[*line.ringed], ring_radius, color);
    }
}

}  // namespace

Chart drawn(const LinePlot& plot) {
    check(plot);
    const ChartAxis x = axis_for(plot.x, range_of(plot, plot.x, &ChartPoint::x));
    const ChartAxis y = axis_for(plot.y, range_of(plot, plot.y, &ChartPoint::y));
    std::vector<LegendEntry> entries;
    for (const PlotLine& line : plot.lines) {
        if (!line.name.empty()) {
            entries.push_back({line.name, series_color(line.color), line.dashed, true});
        }
    }
    Chart chart;
    const double top = draw_heading(chart, plot.title, plot.y.label, plot_margin);
    const double left = plot_margin + y_axis_width(y);
    const ChartBox box{left, top, left + area_width, top + area_height};
    draw_y_axis(chart, box, y);
    draw_x_axis(chart, box, x, plot.x.label);
    for (const PlotLine& line : plot.lines) {
        draw_line(chart, box, x, y, line);
    }
    const double right = box.right + plot_margin;
    draw_legend_column(chart, entries, {right, top - line_height / 2});
    chart.width = std::max({right + legend_width(entries) + plot_margin,
                            text_width(plot.title, title_px) + 2 * plot_margin});
    const double legend_height = static_cast<double>(entries.size()) * line_height;
    const double below = top + std::max(area_height + x_axis_height, legend_height);
    chart.height = draw_note(chart, plot.note, below, chart.width - 2 * plot_margin) + plot_margin;
    return chart;
}

}  // namespace pxpl5::host
