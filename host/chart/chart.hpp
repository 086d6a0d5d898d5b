// Charts as marks: texts, lines, bars, axes and legends of one style. Lengths are pixels; y points
// down. The io process draws the marks.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/chart_axis.hpp"
#include "host/scene/marks.hpp"

namespace pxpl5::host {

inline constexpr double text_px = 12;
inline constexpr double title_px = 15;
inline constexpr MarkColor chart_ink{38, 42, 48, 255}, pale_ink{90, 96, 104, 255},
    grid_ink{0, 0, 0, 26}, axis_ink{0, 0, 0, 110};

/// One of eight colors that stay apart for color-blind readers; the ninth is the first again.
MarkColor series_color(std::size_t index);

struct ChartPoint {
    double x = 0, y = 0;
};

struct ChartBox {
    double left = 0, top = 0, right = 0, bottom = 0;
    /// The point at which two axes show two values.
    ChartPoint at(const ChartAxis& x, double x_value, const ChartAxis& y, double y_value) const;
    double x(const ChartAxis& axis, double value) const;
    double y(const ChartAxis& axis, double value) const;
};

struct ChartText {
    double size_px = text_px;
    float align_x = 0;  ///< 0: begins at the point; 0.5: centered; 1: ends at the point.
    MarkColor color = chart_ink;
};

/// The marks of a chart on white, or of a part of a chart.
struct Chart {
    double width = 0, height = 0;
    std::vector<PictureMark> marks;

    /// Adds a text whose base line goes through `at`. An empty text adds nothing.
    void text(ChartPoint at, const std::string& text, const ChartText& style = {});
    void line(std::span<const ChartPoint> points, MarkColor color, double width_px = 1);
    void line(ChartPoint from, ChartPoint to, MarkColor color, double width_px = 1);
    void dashed(std::span<const ChartPoint> points, MarkColor color, double width_px);
    void area(const ChartBox& box, MarkColor color);
    void disc(ChartPoint center, double radius, MarkColor color);
    void ring(ChartPoint center, double radius, MarkColor color);
    /// Adds the marks of `other`, moved by `at`.
    void place(const Chart& other, ChartPoint at);
};

/// The chart `factor` times as large.
Chart scaled(Chart chart, double factor);

/// The width of a line of text in the font of all marks; a little too wide rather than too narrow.
double text_width(std::string_view text, double size_px = text_px);

inline constexpr double plot_margin = 14;  ///< Around each plot.
inline constexpr double line_height = 16;  ///< For texts of text_px.
inline constexpr double tick_gap = 6;      ///< Between an axis and its numbers.
inline constexpr int most_ticks = 8;

/// Three digits, and more before the decimal point: "0.25", "16.7", "409", "1,234".
std::string short_number(double value);

/// One name and its color in a legend.
struct LegendEntry {
    std::string name;
    MarkColor color;
    bool dashed = false;
    bool is_line = false;
};

double legend_width(std::span<const LegendEntry> entries);
/// Draws the entries below each other, from `at` down.
void draw_legend_column(Chart& chart, std::span<const LegendEntry> entries, ChartPoint at);
/// Draws the entries in rows of at most `width`. Returns the height.
double draw_legend_row(Chart& chart, std::span<const LegendEntry> entries, ChartPoint at,
                       double width);

/// Draws the title and, below it, the label of the vertical axis. Returns the y behind them.
double draw_heading(Chart& chart, const std::string& title, const std::string& y_label, double y);

/// Draws the note in lines of at most `width`. Returns the y behind the last line.
double draw_note(Chart& chart, const std::string& note, double y, double width);

/// The text in lines, each at most `width` wide unless a single word is wider.
std::vector<std::string> broken(const std::string& text, double width, double size_px = text_px);

/// Draws grid lines with numbers at the left. y_axis_width() is the width of the numbers.
void draw_y_axis(Chart& chart, const ChartBox& box, const ChartAxis& axis);
double y_axis_width(const ChartAxis& axis);
/// Draws grid lines with numbers and the label below. Skips numbers that would touch.
void draw_x_axis(Chart& chart, const ChartBox& box, const ChartAxis& axis,
                 const std::string& label);
inline constexpr double x_axis_height = 2 * line_height + tick_gap;

}  // namespace pxpl5::host
