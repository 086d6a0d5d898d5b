// Plots as SVG: lines, grouped bars, changes to either side of nothing. Plain data in, text out.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace pxpl5::host::timing {

enum class PlotScale : std::uint8_t { linear, log2 };

struct PlotAxis {
    std::string label;  ///< What, and in which unit.
    PlotScale scale = PlotScale::linear;
};

struct PlotPoint {
    double x = 0, y = 0;
};

struct PlotLine {
    std::string name;  ///< For the legend; none if empty.
    std::vector<PlotPoint> points;
    std::size_t colour = 0;             ///< Index of one of eight, going round.
    bool dashed = false;                ///< Without marks at its points.
    std::optional<std::size_t> ringed;  ///< A point that is told apart, by index.
};

/// Curves over one axis. A linear axis without negative values begins at 0.
struct LinePlot {
    std::string title, note;  ///< The note stands below; either may be empty.
    PlotAxis x, y;
    std::vector<PlotLine> lines;
};

struct PlotBars {
    std::string name;
    std::vector<std::optional<double>> values;  ///< One a group, >= 0.
};

/// Bars in groups, each with its value over it.
struct BarPlot {
    std::string title, note;
    std::string y_label;
    std::vector<std::string> groups;  ///< Broken into lines at blanks.
    std::vector<PlotBars> series;
};

struct PlotChange {
    std::string name;
    double low = 0, high = 0;  ///< With the parameter lower, and higher.
};

/// How something changes with each of several parameters: a bar to either side of 0 for each.
struct ChangePlot {
    std::string title, note;
    std::string x_label;
    std::string low_name, high_name;  ///< What the two bars are.
    std::vector<PlotChange> changes;
};

using Plot = std::variant<LinePlot, BarPlot, ChangePlot>;

/// The plots as one SVG document, `columns` beside each other, on white.
///
/// Throws RequestError (bad_data) that names plot, series and point: a value that is no finite
/// number, not > 0 on an axis of octaves, or a negative bar; bars that are not as many as the
/// groups; a plot or a series that has nothing to show; no plots or columns.
std::string svg_of(std::span<const Plot> plots, std::size_t columns = 1);

/// The text in XML: & < > and quotes are escaped, control characters left out.
std::string xml_text(const std::string& text);

}  // namespace pxpl5::host::timing
