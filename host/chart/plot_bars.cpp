#include <fmt/format.h>

#include <algorithm>

#include "host/chart/plot.hpp"

namespace pxpl5::host {

namespace {

constexpr double area_height = 240, least_bar = 18, least_gap = 16, value_px = 10;
constexpr double least_width = 380;

void check(const BarPlot& plot) {
    if (plot.groups.empty() || plot.series.empty()) {
        refuse_plot(plot.title, fmt::format("it has {} groups and {} series", plot.groups.size(),
                                            plot.series.size()));
    }
    for (const PlotBars& series : plot.series) {
        if (series.values.size() != plot.groups.size()) {
            refuse_plot(plot.title,
                        fmt::format("'{}' has {} bars, but there are {} groups", series.name,
                                    series.values.size(), plot.groups.size()));
        }
        for (std::size_t i = 0; i < series.values.size(); ++i) {
            const double value = series.values[i].value_or(0);
            const std::string where = fmt::format("'{}' of {}", series.name, plot.groups[i]);
            check_number(plot.title, where, value);
            if (value < 0) {
                refuse_plot(plot.title, fmt::format("{} is {}, less than 0", where, value));
            }
        }
    }
}

/// Widths of what stands beside each other.
struct Pitch {
    double bar = least_bar, group = 0, gap = least_gap;
};

Pitch pitch_of(const BarPlot& plot) {
    Pitch pitch;
    for (const PlotBars& series : plot.series) {
        for (const std::optional<double>& value : series.values) {
            const double width = value ? text_width(short_number(*value), value_px) + 3 : 0;
            pitch.bar = std::max(pitch.bar, width);
        }
    }
    pitch.group = pitch.bar * static_cast<double>(plot.series.size());
    for (const std::string& group : plot.groups) {
        for (const std::string& word : broken(group, 0)) {
            pitch.group = std::max(pitch.group, text_width(word));
        }
    }
    pitch.gap =
        std::max(pitch.gap, least_width / static_cast<double>(plot.groups.size()) - pitch.group);
    return pitch;
}

double highest_of(const BarPlot& plot) {
    double highest = 0;
    for (const PlotBars& series : plot.series) {
        for (const std::optional<double>& value : series.values) {
            highest = std::max(highest, value.value_or(0));
        }
    }
    return highest;
}

/// The bars of one group, whose left edge is at x, and its name.
void draw_group(Chart& chart, const BarPlot& plot, const ChartBox& box, const ChartAxis& axis,
                const Pitch& pitch, std::size_t group, double x) {
    const double bottom = box.bottom;
    const double bars = pitch.bar * static_cast<double>(plot.series.size());
    double left = x + (pitch.group - bars) / 2;
    for (std::size_t i = 0; i < plot.series.size(); ++i, left += pitch.bar) {
        const std::optional<double>& value = plot.series[i].values[group];
        if (value) {
            const double top = box.y(axis, *value);
            chart.area({left + 1, top, left + pitch.bar - 1, bottom}, series_color(i));
            chart.text({left + pitch.bar / 2, top - 3}, short_number(*value),
                       {.size_px = value_px, .align_x = 0.5F});
        }
    }
    double y = bottom;
    for (const std::string& line : broken(plot.groups[group], pitch.group)) {
        y += line_height;
        chart.text({x + pitch.group / 2, y}, line, {.align_x = 0.5F});
    }
}

double names_height(const BarPlot& plot, const Pitch& pitch) {
    std::size_t lines = 0;
    for (const std::string& group : plot.groups) {
        lines = std::max(lines, broken(group, pitch.group).size());
    }
    return static_cast<double>(lines) * line_height;
}

}  // namespace

Chart drawn(const BarPlot& plot) {
    check(plot);
    const ChartAxis axis = axis_from_zero(highest_of(plot), most_ticks);
    const Pitch pitch = pitch_of(plot);
    std::vector<LegendEntry> entries;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        entries.push_back({plot.series[i].name, series_color(i)});
    }
    Chart chart;
    const double top = draw_heading(chart, plot.title, plot.y_label, plot_margin);
    const double left = plot_margin + y_axis_width(axis);
    const double width = static_cast<double>(plot.groups.size()) * (pitch.group + pitch.gap);
    // Values over the highest bars must not touch the legend.
    const double box_top =
        top + draw_legend_row(chart, entries, {plot_margin, top - tick_gap}, width) + value_px;
    const ChartBox box{left, box_top, left + width, box_top + area_height};
    draw_y_axis(chart, box, axis);
    double x = box.left + pitch.gap / 2;
    for (std::size_t group = 0; group < plot.groups.size(); ++group) {
        draw_group(chart, plot, box, axis, pitch, group, x);
        x += pitch.group + pitch.gap;
    }
    chart.line({box.left, box.bottom}, {box.right, box.bottom}, axis_ink);
    chart.width = std::max(box.right, text_width(plot.title, title_px) + plot_margin) + plot_margin;
    chart.height = draw_note(chart, plot.note, box.bottom + names_height(plot, pitch) + tick_gap,
                             chart.width - 2 * plot_margin) +
                   plot_margin;
    return chart;
}

}  // namespace pxpl5::host
