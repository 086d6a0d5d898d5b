// Plots as charts: lines, grouped bars, and bars to both sides of zero.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "host/chart/chart.hpp"

namespace pxpl5::host {

enum class PlotScale : std::uint8_t { linear, log2 };

struct PlotAxis {
    std::string label;  ///< Quantity and unit.
    PlotScale scale = PlotScale::linear;
};

struct PlotLine {
    std::string name;  ///< Shown in the legend; a line without a name has no legend entry.
    std::vector<ChartPoint> points;
    std::size_t color = 0;              ///< Index for series_color().
    bool dashed = false;                ///< A dashed line has no discs at its points.
    std::optional<std::size_t> ringed;  ///< Index of a point with a ring around it.
};

/// Curves over one axis. A linear axis without negative values begins at 0.
struct LinePlot {
    std::string title, note;  ///< The note is below the plot. Both may be empty.
    PlotAxis x, y;
    std::vector<PlotLine> lines;
};

struct PlotBars {
    std::string name;
    std::vector<std::optional<double>> values;  ///< One per group, >= 0.
};

/// Bars in groups. Each bar has its value above.
struct BarPlot {
    std::string title, note;
    std::string y_label;
    std::vector<std::string> groups;  ///< Long names continue on the next line.
    std::vector<PlotBars> series;
};

struct PlotChange {
    std::string name;
    double low = 0, high = 0;  ///< Results with the parameter lower and higher.
};

/// The effect of several parameters on one figure: two bars per parameter, from 0.
struct ChangePlot {
    std::string title, note;
    std::string x_label;
    std::string low_name, high_name;  ///< Names of the two bars.
    std::vector<PlotChange> changes;
};

using Plot = std::variant<LinePlot, BarPlot, ChangePlot>;

/// Draws the plots on one chart, `columns` in a row.
///
/// Throws RequestError (bad_data) that names plot, series and point, if a value is not finite, a
/// value on an axis of octaves is not > 0, a bar is negative, the number of bars differs from the
/// number of groups, a plot or a series is empty, or there are no plots or columns.
Chart chart_of(std::span<const Plot> plots, std::size_t columns = 1);

// The three kinds; width and height include the margin.
Chart drawn(const LinePlot& plot);
Chart drawn(const BarPlot& plot);
Chart drawn(const ChangePlot& plot);

/// Throws RequestError (bad_data): `plot`, then `reason`.
[[noreturn]] void refuse_plot(const std::string& plot, const std::string& reason);

/// Throws if the value is not finite. `where` names series and point.
void check_number(const std::string& plot, const std::string& where, double value);

}  // namespace pxpl5::host
