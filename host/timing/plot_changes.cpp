#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/timing/plot_parts.hpp"

namespace pxpl5::host::timing {

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

void draw_bar(Svg& svg, const Box& box, const ChartAxis& axis, double y, double value,
              std::string_view colour) {
    const double zero = x_in(box, axis, 0), end = x_in(box, axis, value);
    svg.rectangle({std::min(zero, end), y, std::abs(end - zero), bar_height}, colour);
    const bool to_left = value < 0;
    svg.text({end + (to_left ? -4 : 4), y + bar_height - 2},
             (value > 0 ? "+" : "") + short_number(value),
             {.anchor = to_left ? Anchor::end : Anchor::start, .size_px = value_px});
}

}  // namespace

Svg drawn(const ChangePlot& plot) {
    check(plot);
    const ChartAxis axis = axis_of(plot);
    const std::array<LegendEntry, 2> entries{LegendEntry{plot.low_name, colour_of(0)},
                                             LegendEntry{plot.high_name, colour_of(1)}};
    double names = 0;
    for (const PlotChange& change : plot.changes) {
        names = std::max(names, text_width(change.name));
    }
    Svg svg;
    const double top = draw_heading(svg, plot.title, "", plot_margin);
    Box box{plot_margin + names + tick_gap, top, area_width,
            static_cast<double>(plot.changes.size()) * row_height};
    box.y += draw_legend_row(svg, entries, {plot_margin, top - tick_gap}, box.width);
    draw_x_axis(svg, box, axis, plot.x_label);
    double y = box.y + (row_height - 2 * bar_height) / 2;
    for (const PlotChange& change : plot.changes) {
        svg.text({box.x - tick_gap, y + bar_height + text_px * 0.35}, change.name,
                 {.anchor = Anchor::end});
        draw_bar(svg, box, axis, y, change.low, entries[0].colour);
        draw_bar(svg, box, axis, y + bar_height, change.high, entries[1].colour);
        y += row_height;
    }
    const double zero = x_in(box, axis, 0);
    svg.line({zero, box.y}, {zero, box.y + box.height}, axis_ink);
    svg.width =
        std::max(box.x + box.width, text_width(plot.title, title_px) + plot_margin) + plot_margin;
    svg.height =
        draw_note(svg, plot.note, box.y + box.height + x_axis_height, svg.width - 2 * plot_margin) +
        plot_margin;
    return svg;
}

}  // namespace pxpl5::host::timing
