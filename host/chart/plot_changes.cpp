#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/chart/plot.hpp"

namespace pxpl5::host {

namespace {

constexpr double area_width = 420, row_height = 30, bar_height = 12, value_px = 10;

void check(const ChangePlot& plot) {
    if (plot.changes.empty()) {
        refuse_plot(plot.title, "it has no bars");
    }
    for (const PlotChange& change : plot.changes) {
        check_number(plot.title, fmt::format("'{}' of {}", plot.low_name, change.name), change.low);
        check_number(plot.title, fmt::format("'{}' of {}", plot.high_name, change.name),
                     change.high);
    }
}

/// Wide enough that a value fits beside the longest bar.
ChartAxis axis_of(const ChangePlot& plot) {
    double low = 0, high = 0;
    for (const PlotChange& change : plot.changes) {
        low = std::min({low, change.low, change.high});
        high = std::max({high, change.low, change.high});
    }
    if (low == high) {
        low = -1;
        high = 1;
    }
    constexpr double value_room = 0.12;
    const double room = (high - low) * value_room;
    return linear_axis(low - room, high + room, most_ticks);
}

void draw_bar(Chart& chart, const ChartBox& box, const ChartAxis& axis, double y, double value,
              MarkColor color) {
    const double zero = box.x(axis, 0), end = box.x(axis, value);
    chart.area({std::min(zero, end), y, std::max(zero, end), y + bar_height}, color);
    const bool to_left = value < 0;
    chart.text({end + (to_left ? -4 : 4), y + bar_height - 2},
               (value > 0 ? "+" : "") + short_number(value),
               {.size_px = value_px, .align_x = to_left ? 1.0F : 0.0F});
}

}  // namespace

Chart drawn(const ChangePlot& plot) {
    check(plot);
    const ChartAxis axis = axis_of(plot);
    const std::array<LegendEntry, 2> entries{LegendEntry{plot.low_name, series_color(0)},
                                             LegendEntry{plot.high_name, series_color(1)}};
    double names = 0;
    for (const PlotChange& change : plot.changes) {
        names = std::max(names, text_width(change.name));
    }
    Chart chart;
    const double top = draw_heading(chart, plot.title, "", plot_margin);
    const double left = plot_margin + names + tick_gap;
    const double box_top =
        top + draw_legend_row(chart, entries, {plot_margin, top - tick_gap}, area_width);
    const ChartBox box{left, box_top, left + area_width,
                       box_top + static_cast<double>(plot.changes.size()) * row_height};
    draw_x_axis(chart, box, axis, plot.x_label);
    double y = box.top + (row_height - 2 * bar_height) / 2;
    for (const PlotChange& change : plot.changes) {
        chart.text({box.left - tick_gap, y + bar_height + text_px * 0.35}, change.name,
                   {.align_x = 1});
        draw_bar(chart, box, axis, y, change.low, entries[0].color);
        draw_bar(chart, box, axis, y + bar_height, change.high, entries[1].color);
        y += row_height;
    }
    const double zero = box.x(axis, 0);
    chart.line({zero, box.top}, {zero, box.bottom}, axis_ink);
    chart.width = std::max(box.right, text_width(plot.title, title_px) + plot_margin) + plot_margin;
    chart.height =
        draw_note(chart, plot.note, box.bottom + x_axis_height, chart.width - 2 * plot_margin) +
        plot_margin;
    return chart;
}

}  // namespace pxpl5::host
