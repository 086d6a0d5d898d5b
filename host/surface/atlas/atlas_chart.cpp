#include "host/surface/atlas/atlas_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/error.hpp"
#include "host/chart/chart.hpp"

namespace pxpl5::host {

namespace {

constexpr MarkColor paper{255, 255, 255, 255}, histogram_gray{229, 232, 235, 255},
    plateau_tint{240, 188, 84, 62}, plateau_ink{140, 92, 8, 255};
constexpr double mm2_per_cm2 = 100, mm3_per_ml = 1000;
/// A measure has a logarithmic axis if its largest value is more than this many times its median.
/// On a linear axis, noise at one end would press all other values to the ground.
constexpr double widest_linear = 8;
/// A logarithmic axis covers at most this factor: the last voxels are of no interest.
constexpr double widest_logarithmic = 1e5;

/// One of the four measures.
struct Panel {
    std::string name;
    MarkColor color;
    std::vector<double> values;  ///< One per row.
    ChartAxis axis;
};

/// The chart while it is drawn, in pixels of a picture of atlas_chart_size.
struct Drawing {
    const AtlasContent& content;
    ChartAxis isovalues;
    Chart chart;

    void text(ChartPoint at, const std::string& text, MarkColor color, const TextStyle& style) {
        chart.marks.push_back(
            text_mark({static_cast<float>(at.x), static_cast<float>(at.y)}, text, color, style));
    }
};

/// Returns an axis for values >= 0.
ChartAxis axis_for(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const double highest = values.back(), median = values[values.size() / 2];
    const auto lowest = std::upper_bound(values.begin(), values.end(), 0.0);
    if (lowest == values.end() || highest <= widest_linear * median) {
        return axis_from_zero(highest, 5);
    }
    return logarithmic_axis(std::max(*lowest, highest / widest_logarithmic), highest, 5);
}

Panel panel_of(const AtlasContent& content, const std::string& name, MarkColor color,
               double (*measure)(const AtlasRow&)) {
    Panel panel{name, color, {}, {}};
    for (const AtlasRow& row : content.rows) {
        panel.values.push_back(std::max(measure(row), 0.0));
    }
    panel.axis = axis_for(panel.values);
    panel.name += panel.axis.logarithmic ? ", logarithmic" : "";
    return panel;
}

std::array<Panel, 4> panels_of(const AtlasContent& content) {
    return {panel_of(content, "triangles", {31, 95, 139, 255},
                     [](const AtlasRow& row) { return static_cast<double>(row.triangles); }),
            panel_of(content, "area, cm²", {34, 120, 92, 255},
                     [](const AtlasRow& row) { return row.area_mm2 / mm2_per_cm2; }),
            panel_of(content, "volume, ml", {136, 66, 120, 255},
                     [](const AtlasRow& row) { return row.volume_mm3 / mm3_per_ml; }),
            panel_of(content, "components", {176, 74, 46, 255},
                     [](const AtlasRow& row) { return static_cast<double>(row.components); })};
}

/// Draws the counts as a filled outline of logarithmic height.
void add_histogram(const ChartBox& box, Drawing& d) {
    const AtlasHistogram& histogram = d.content.histogram;
    const std::size_t bins = histogram.counts.size();
    if (bins == 0 || !(histogram.high > histogram.low)) {
        return;
    }
    const double width = (histogram.high - histogram.low) / static_cast<double>(bins);
    const std::uint64_t most = std::max<std::uint64_t>(1, std::ranges::max(histogram.counts));
    const ChartAxis heights{0, std::log1p(static_cast<double>(most)) / 0.92, false, {}};
    std::vector<glm::vec2> outline;
    const auto add = [&](double isovalue, double height) {
        const ChartPoint p = box.at(d.isovalues, isovalue, heights, height);
        outline.emplace_back(static_cast<float>(p.x), static_cast<float>(p.y));
    };
    for (std::size_t bin = 0; bin < bins; ++bin) {
        const double low = histogram.low + width * static_cast<double>(bin), high = low + width;
        if (high > d.isovalues.low && low < d.isovalues.high) {
            const double height = std::log1p(static_cast<double>(histogram.counts[bin]));
            add(low, height);
            add(high, height);
        }
    }
    if (!outline.empty()) {
        add(histogram.high, 0);
        outline.back().x = outline[outline.size() - 2].x;
        add(histogram.low, 0);
        outline.back().x = outline.front().x;
        d.chart.marks.push_back(area_mark(std::move(outline), histogram_gray));
    }
}

/// The isovalue to a thousandth of the axis: more digits would not show a visible difference.
std::string short_text(double isovalue, const Drawing& d) {
    const double range = d.isovalues.high - d.isovalues.low;
    const double step = std::pow(10.0, std::floor(std::log10(range / 1000)));
    return grouped(std::round(isovalue / step) * step + 0.0);
}

/// Draws bands over all panels, and above them their numbers, with the range where it fits.
void add_plateaus(const ChartBox& all, Drawing& d) {
    int number = 0;
    for (const AtlasPlateau& plateau : d.content.plateaus) {
        const double left = all.x(d.isovalues, plateau.from);
        const double right = all.x(d.isovalues, plateau.to);
        ++number;
        if (!(right > left)) {
            continue;
        }
        d.chart.area({left, all.top, right, all.bottom}, plateau_tint);
        const std::string range = fmt::format("{}: {} to {}", number, short_text(plateau.from, d),
                                              short_text(plateau.to, d));
        const bool fits = right - left > text_width(range, 13);
        d.text({(left + right) / 2, all.top - 4}, fits ? range : fmt::format("{}", number),
               plateau_ink, {13, 0.5F, 1, 2});
    }
}

void add_grid(const ChartBox& box, const Panel& panel, Drawing& d) {
    for (const double tick : d.isovalues.ticks) {
        const double x = box.x(d.isovalues, tick);
        d.chart.line({x, box.top}, {x, box.bottom}, grid_ink);
    }
    for (const double tick : panel.axis.ticks) {
        const double y = box.y(panel.axis, tick);
        d.chart.line({box.left, y}, {box.right, y}, grid_ink);
        d.text({box.left - 8, y}, grouped(tick), pale_ink, {12, 1, 0.5F, 0});
    }
}

void add_curve(const ChartBox& box, const Panel& panel, Drawing& d) {
    std::vector<ChartPoint> points;
    for (std::size_t index = 0; index < panel.values.size(); ++index) {
        points.push_back(
            box.at(d.isovalues, d.content.rows[index].isovalue, panel.axis, panel.values[index]));
    }
    // White on both sides separates the curve from the histogram's edge.
    d.chart.line(points, {255, 255, 255, 190}, 5);
    d.chart.line(points, panel.color, 2.2);
    d.text({box.right - 10, box.top + 7}, panel.name, panel.color, {15, 1, 0, 4});
    d.chart.line({box.left, box.bottom}, {box.right, box.bottom}, axis_ink);
}

void add_axis(const ChartBox& all, Drawing& d) {
    for (const double tick : d.isovalues.ticks) {
        const double x = all.x(d.isovalues, tick);
        d.chart.line({x, all.bottom}, {x, all.bottom + 5}, axis_ink);
        d.text({x, all.bottom + 8}, grouped(tick), pale_ink, {12, 0.5F, 0, 0});
    }
    const std::string unit =
        d.content.value_unit.empty() ? "" : fmt::format(", {}", d.content.value_unit);
    d.text({(all.left + all.right) / 2, all.bottom + 28}, "isovalue" + unit, chart_ink,
           {14, 0.5F, 0, 0});
}

/// Draws the title and the legend of gray and amber.
void add_heading(const ChartBox& all, Drawing& d) {
    d.text({all.left, 20}, d.content.title, chart_ink, {20, 0, 0, 0});
    constexpr double y = 55, side = 12;
    double x = all.left;
    const auto key = [&](MarkColor color, const std::string& text) {
        d.chart.area({x, y, x + side, y + side}, color);
        d.text({x + side + 7, y + side / 2}, text, pale_ink, {12.5, 0, 0.5F, 0});
        x += side + 7 + text_width(text, 12.5) + 24;
    };
    if (!d.content.histogram.counts.empty()) {
        key(histogram_gray, "frequency of the values (logarithmic)");
    }
    if (!d.content.plateaus.empty()) {
        key({plateau_tint.r, plateau_tint.g, plateau_tint.b, 110},
            "plateaus: the surface changes little");
    }
}

}  // namespace

AtlasChart atlas_chart(const AtlasContent& content, Size size) {
    const std::vector<AtlasRow>& rows = content.rows;
    const auto ascends = [](const AtlasRow& a, const AtlasRow& b) {
        return a.isovalue < b.isovalue;
    };
    if (rows.size() < 2) {
        throw RequestError(ExitCode::failed,
                           fmt::format("an atlas needs 2 isovalues or more, got {}", rows.size()));
    }
    for (std::size_t index = 1; index < rows.size(); ++index) {
        if (!ascends(rows[index - 1], rows[index])) {
            throw RequestError(ExitCode::failed,
                               fmt::format("an atlas's isovalues ascend, but {} follows {}",
                                           rows[index].isovalue, rows[index - 1].isovalue));
        }
    }
    if (std::min(size.width, size.height) < atlas_chart_least_px) {
        throw RequestError(ExitCode::failed,
                           fmt::format("an atlas of {}x{} pixels, each side must be {} or more",
                                       size.width, size.height, atlas_chart_least_px));
    }
    const double unit = std::min(static_cast<double>(size.width) / atlas_chart_size.width,
                                 static_cast<double>(size.height) / atlas_chart_size.height);
    const double width = size.width / unit, height = size.height / unit;
    Drawing d{content, linear_axis(rows.front().isovalue, rows.back().isovalue, 14), {}};
    const ChartBox all{96, 100, width - 28, height - 58};
    constexpr double gap = 16;
    const double panel_height = (all.bottom - all.top - 3 * gap) / 4;
    const std::array panels = panels_of(content);
    std::array<ChartBox, 4> boxes{};
    for (std::size_t index = 0; index < panels.size(); ++index) {
        const double top = all.top + static_cast<double>(index) * (panel_height + gap);
        boxes[index] = {all.left, top, all.right, top + panel_height};
        add_histogram(boxes[index], d);
    }
    add_plateaus(all, d);
    for (std::size_t index = 0; index < panels.size(); ++index) {
        add_grid(boxes[index], panels[index], d);
        add_curve(boxes[index], panels[index], d);
    }
    add_axis(all, d);
    add_heading(all, d);
    return {size, paper, scaled(std::move(d.chart), unit).marks};
}

}  // namespace pxpl5::host
