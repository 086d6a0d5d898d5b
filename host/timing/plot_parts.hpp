// What plots share: checks, numbers, the frame with its axes, the legend.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/chart_axis.hpp"
#include "host/timing/svg.hpp"

namespace pxpl5::host::timing {

inline constexpr double plot_margin = 14;  ///< Around each plot.
inline constexpr double line_height = 16;  ///< Of text_px.
inline constexpr double tick_gap = 6;      ///< Between an axis and its numbers.
inline constexpr int most_ticks = 8;

/// Throws RequestError (bad_data): `plot`, then `what`.
[[noreturn]] void refuse_plot(const std::string& plot, const std::string& what);

/// Throws if the value is no finite number. `where` names series and point.
void check_number(const std::string& plot, const std::string& where, double value);

/// Three digits, more before the point: "0.25", "16.7", "409", "1,234".
std::string short_number(double value);

/// What names a colour.
struct LegendEntry {
    std::string name;
    std::string_view colour;
    bool dashed = false;
    bool is_line = false;
};

/// Entries one under the other, from `at` down. Returns the width that they need.
double legend_width(std::span<const LegendEntry> entries);
void draw_legend_column(Svg& svg, std::span<const LegendEntry> entries, PlotPoint at);
/// Entries beside each other, as many rows as `width` makes needed. Returns the height.
double draw_legend_row(Svg& svg, std::span<const LegendEntry> entries, PlotPoint at, double width);

/// Title and, under it, the label of the vertical axis. Returns where the next may begin.
double draw_heading(Svg& svg, const std::string& title, const std::string& y_label, double y);

/// The note, broken into lines of `width`, from `y` down. Returns where the next may begin.
double draw_note(Svg& svg, const std::string& note, double y, double width);

/// The text in lines, each at most `width` wide unless a word is wider.
std::vector<std::string> broken(const std::string& text, double width, double size_px = text_px);

/// Where an axis shows a value within the box.
double x_in(const Box& box, const ChartAxis& axis, double value);
double y_in(const Box& box, const ChartAxis& axis, double value);

/// Grid lines with numbers at the left, and the width that these numbers need.
void draw_y_axis(Svg& svg, const Box& box, const ChartAxis& axis);
double y_axis_width(const ChartAxis& axis);
/// Grid lines with numbers and the label below. Numbers that would touch are left out.
void draw_x_axis(Svg& svg, const Box& box, const ChartAxis& axis, const std::string& label);
inline constexpr double x_axis_height = 2 * line_height + tick_gap;

// The three kinds; width and height are of the whole plot with its margin.
Svg drawn(const LinePlot& plot);
Svg drawn(const BarPlot& plot);
Svg drawn(const ChangePlot& plot);

}  // namespace pxpl5::host::timing
