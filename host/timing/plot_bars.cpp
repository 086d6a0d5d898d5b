#include <fmt/format.h>

#include <algorithm>

#include "host/timing/plot_parts.hpp"

namespace pxpl5::host::timing {

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
void draw_group(Svg& svg, const BarPlot& plot, const Box& box, const ChartAxis& axis,
                const Pitch& pitch, std::size_t group, double x) {
    const double bottom = box.y + box.height;
    const double bars = pitch.bar * static_cast<double>(plot.series.size());
    double left = x + (pitch.group - bars) / 2;
    for (std::size_t i = 0; i < plot.series.size(); ++i, left += pitch.bar) {
        const std::optional<double>& value = plot.series[i].values[group];
        if (value) {
            const double top = y_in(box, axis, *value);
            svg.rectangle({left + 1, top, pitch.bar - 2, bottom - top}, colour_of(i));
            svg.text({left + pitch.bar / 2, top - 3}, short_number(*value),
                     {.anchor = Anchor::middle, .size_px = value_px});
        }
    }
    double y = bottom;
    for (const std::string& line : broken(plot.groups[group], pitch.group)) {
        y += line_height;
        svg.text({x + pitch.group / 2, y}, line, {.anchor = Anchor::middle});
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

Svg drawn(const BarPlot& plot) {
    check(plot);
    const ChartAxis axis = axis_from_zero(highest_of(plot), most_ticks);
    const Pitch pitch = pitch_of(plot);
    std::vector<LegendEntry> entries;
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        entries.push_back({plot.series[i].name, colour_of(i)});
    }
    Svg svg;
    const double top = draw_heading(svg, plot.title, plot.y_label, plot_margin);
    Box box{plot_margin + y_axis_width(axis), top,
            static_cast<double>(plot.groups.size()) * (pitch.group + pitch.gap), area_height};
    // Values over the highest bars must not touch the legend.
    box.y += draw_legend_row(svg, entries, {plot_margin, top - tick_gap}, box.width) + value_px;
    draw_y_axis(svg, box, axis);
    double x = box.x + pitch.gap / 2;
    for (std::size_t group = 0; group < plot.groups.size(); ++group) {
        draw_group(svg, plot, box, axis, pitch, group, x);
        x += pitch.group + pitch.gap;
    }
    const double bottom = box.y + box.height;
    svg.line({box.x, bottom}, {box.x + box.width, bottom}, axis_ink);
    svg.width =
        std::max(box.x + box.width, text_width(plot.title, title_px) + plot_margin) + plot_margin;
    svg.height = draw_note(svg, plot.note, bottom + names_height(plot, pitch) + tick_gap,
                           svg.width - 2 * plot_margin) +
                 plot_margin;
    return svg;
}

}  // namespace pxpl5::host::timing
