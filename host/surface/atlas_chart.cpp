#include "host/surface/atlas_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/chart_axis.hpp"
#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

constexpr MarkColour paper{255, 255, 255, 255}, ink{38, 42, 48, 255}, grey_ink{104, 110, 118, 255},
    grid{0, 0, 0, 22}, frame{0, 0, 0, 70}, histogram_grey{229, 232, 235, 255},
    plateau_tint{240, 188, 84, 62}, plateau_ink{140, 92, 8, 255};
constexpr double mm2_per_cm2 = 100, mm3_per_ml = 1000;
/// A measure whose largest value is more than so many times its median is shown on a logarithmic
/// axis: noise at one end must not press everything else to the ground.
constexpr double widest_linear = 8;
/// A logarithmic axis goes no further below its largest value: the last voxels are of no interest.
constexpr double widest_logarithmic = 1e5;

/// One of the four measures.
struct Panel {
    std::string name;
    MarkColour colour;
    std::vector<double> values;  ///< Of each row.
    ChartAxis axis;
};

/// Where a panel lies in the picture.
struct Box {
    double left, top, right, bottom;
};

/// The chart while it is drawn.
struct Drawing {
    const AtlasContent& content;
    double unit;  ///< Pixels: 1 in a picture of atlas_chart_size.
    ChartAxis isovalues;
    std::vector<PictureMark> marks;

    float px(double length) const { return static_cast<float>(length * unit); }
    double x(const Box& box, double isovalue) const {
        return box.left + (box.right - box.left) * isovalues.place(isovalue);
    }
};

glm::vec2 at(double x, double y) {
    return {static_cast<float>(x), static_cast<float>(y)};
}

double y_of(const Box& box, double part) {
    return box.bottom - (box.bottom - box.top) * part;
}

std::vector<glm::vec2> rectangle(const Box& box) {
    return {at(box.left, box.top), at(box.right, box.top), at(box.right, box.bottom),
            at(box.left, box.bottom)};
}

/// An axis for the values; none is below 0.
ChartAxis axis_for(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const double highest = values.back(), median = values[values.size() / 2];
    const auto lowest = std::upper_bound(values.begin(), values.end(), 0.0);
    if (lowest == values.end() || highest <= widest_linear * median) {
        return axis_from_zero(highest, 5);
    }
    return logarithmic_axis(std::max(*lowest, highest / widest_logarithmic), highest, 5);
}

Panel panel_of(const AtlasContent& content, const std::string& name, MarkColour colour,
               double (*measure)(const AtlasRow&)) {
    Panel panel{name, colour, {}, {}};
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

/// Counts as a filled outline, of logarithmic height, over the part of the axis that is shown.
void add_histogram(const Box& box, Drawing& d) {
    const AtlasHistogram& histogram = d.content.histogram;
    const std::size_t bins = histogram.counts.size();
    if (bins == 0 || !(histogram.high > histogram.low)) {
        return;
    }
    const double width = (histogram.high - histogram.low) / static_cast<double>(bins);
    std::uint64_t most = 1;
    for (const std::uint64_t count : histogram.counts) {
        most = std::max(most, count);
    }
    std::vector<glm::vec2> outline;
    for (std::size_t bin = 0; bin < bins; ++bin) {
        const double low = histogram.low + width * static_cast<double>(bin), high = low + width;
        if (high <= d.isovalues.low || low >= d.isovalues.high) {
            continue;
        }
        const double part = std::log1p(static_cast<double>(histogram.counts[bin])) /
                            std::log1p(static_cast<double>(most));
        const double y = y_of(box, part * 0.92);
        outline.push_back(at(d.x(box, low), y));
        outline.push_back(at(d.x(box, high), y));
    }
    if (outline.empty()) {
        return;
    }
    outline.push_back(at(outline.back().x, box.bottom));
    outline.push_back(at(outline.front().x, box.bottom));
    d.marks.push_back(area_mark(std::move(outline), histogram_grey));
}

/// The isovalue to a thousandth of the axis: in a label, what cannot be seen is in the way.
std::string short_text(double isovalue, const Drawing& d) {
    const double range = d.isovalues.high - d.isovalues.low;
    const double step = std::pow(10.0, std::floor(std::log10(range / 1000)));
    return grouped(std::round(isovalue / step) * step + 0.0);
}

/// Bands over all panels, and above them their numbers, with the range where there is room.
void add_plateaus(const Box& all, Drawing& d) {
    int number = 0;
    for (const AtlasPlateau& plateau : d.content.plateaus) {
        const double left = d.x(all, plateau.from), right = d.x(all, plateau.to);
        ++number;
        if (!(right > left)) {
            continue;
        }
        d.marks.push_back(area_mark(rectangle({left, all.top, right, all.bottom}), plateau_tint));
        const std::string range = fmt::format("{}: {} to {}", number, short_text(plateau.from, d),
                                              short_text(plateau.to, d));
        const bool has_room = right - left > d.px(7.3) * static_cast<double>(range.size());
        d.marks.push_back(text_mark(at((left + right) / 2, all.top - d.px(4)),
                                    has_room ? range : fmt::format("{}", number), plateau_ink,
                                    {d.px(13), 0.5F, 1, d.px(2)}));
    }
}

void add_grid(const Box& box, const Panel& panel, Drawing& d) {
    for (const double tick : d.isovalues.ticks) {
        const double x = d.x(box, tick);
        d.marks.push_back(line_mark({at(x, box.top), at(x, box.bottom)}, grid, d.px(1)));
    }
    for (const double tick : panel.axis.ticks) {
        const double y = y_of(box, panel.axis.place(tick));
        d.marks.push_back(line_mark({at(box.left, y), at(box.right, y)}, grid, d.px(1)));
        d.marks.push_back(
            text_mark(at(box.left - d.px(8), y), grouped(tick), grey_ink, {d.px(12), 1, 0.5F, 0}));
    }
}

void add_curve(const Box& box, const Panel& panel, Drawing& d) {
    std::vector<glm::vec2> points;
    for (std::size_t index = 0; index < panel.values.size(); ++index) {
        points.push_back(at(d.x(box, d.content.rows[index].isovalue),
                            y_of(box, panel.axis.place(panel.values[index]))));
    }
    // Paper on both sides of the curve parts it from the histogram's edge.
    d.marks.push_back(line_mark(points, {255, 255, 255, 190}, d.px(5)));
    d.marks.push_back(line_mark(std::move(points), panel.colour, d.px(2.2)));
    d.marks.push_back(text_mark(at(box.right - d.px(10), box.top + d.px(7)), panel.name,
                                panel.colour, {d.px(15), 1, 0, d.px(4)}));
    d.marks.push_back(
        line_mark({at(box.left, box.bottom), at(box.right, box.bottom)}, frame, d.px(1)));
}

void add_axis(const Box& all, Drawing& d) {
    for (const double tick : d.isovalues.ticks) {
        const double x = d.x(all, tick);
        d.marks.push_back(
            line_mark({at(x, all.bottom), at(x, all.bottom + d.px(5))}, frame, d.px(1)));
        d.marks.push_back(text_mark(at(x, all.bottom + d.px(8)), grouped(tick), grey_ink,
                                    {d.px(12), 0.5F, 0, 0}));
    }
    const std::string unit =
        d.content.value_unit.empty() ? "" : fmt::format(", {}", d.content.value_unit);
    d.marks.push_back(text_mark(at((all.left + all.right) / 2, all.bottom + d.px(28)),
                                "isovalue" + unit, ink, {d.px(14), 0.5F, 0, 0}));
}

/// Title, and what grey and amber mean.
void add_heading(const Box& all, Drawing& d) {
    d.marks.push_back(text_mark(at(all.left, d.px(20)), d.content.title, ink, {d.px(20), 0, 0, 0}));
    const double y = d.px(55), side = d.px(12);
    const auto key = [&](double x, MarkColour colour, const std::string& text) {
        d.marks.push_back(area_mark(rectangle({x, y, x + side, y + side}), colour));
        d.marks.push_back(text_mark(at(x + side + d.px(7), y + side / 2), text, grey_ink,
                                    {d.px(12.5), 0, 0.5F, 0}));
    };
    if (!d.content.histogram.counts.empty()) {
        key(all.left, histogram_grey, "how often the values occur, logarithmic");
    }
    if (!d.content.plateaus.empty()) {
        key(all.left + d.px(310), {plateau_tint.r, plateau_tint.g, plateau_tint.b, 110},
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
    Drawing d{content, unit, linear_axis(rows.front().isovalue, rows.back().isovalue, 14), {}};
    const Box all{d.px(96), d.px(100), size.width - 28 * unit, size.height - 58 * unit};
    const double gap = d.px(16), height = (all.bottom - all.top - 3 * gap) / 4;
    const std::array panels = panels_of(content);
    std::array<Box, 4> boxes{};
    for (std::size_t index = 0; index < panels.size(); ++index) {
        const double top = all.top + static_cast<double>(index) * (height + gap);
        boxes[index] = {all.left, top, all.right, top + height};
        add_histogram(boxes[index], d);
    }
    add_plateaus(all, d);
    for (std::size_t index = 0; index < panels.size(); ++index) {
        add_grid(boxes[index], panels[index], d);
        add_curve(boxes[index], panels[index], d);
    }
    add_axis(all, d);
    add_heading(all, d);
    return {size, paper, std::move(d.marks)};
}

}  // namespace pxpl5::host
