#include "host/inspect/map/map_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "host/chart/chart.hpp"
#include "host/inspect/map/map_colors.hpp"
#include "isa/contract/region_layout.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr Rgb8 paper{24, 24, 28};
constexpr MarkColor ink{235, 235, 235, 255}, dim_ink{160, 160, 166, 255},
    grid_line{235, 235, 235, 102}, frame_line{90, 90, 98, 255};
constexpr int least_width_px = 336;       ///< Narrower pictures get a margin for the legend.
constexpr int large_width_px = 640;       ///< From this width on the legend's letters are larger.
constexpr double map_part = 0.8;          ///< Share of a count's color over the gray picture.
constexpr double background_part = 0.35;  ///< Brightness of the gray picture without a value.
constexpr int bar_ticks = 5;
constexpr std::size_t most_swatches = 64;  ///< The legend shows at most this many categories.

std::size_t at(int x, int y, int width) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
}

/// Brightness of a drawn pixel, 0..1.
double luminance(std::uint32_t rgb) {
    return (0.2126 * (rgb & 0xFF) + 0.7152 * (rgb >> 8 & 0xFF) + 0.0722 * (rgb >> 16 & 0xFF)) / 255;
}

Rgb8 gray(double brightness) {
    const auto value = static_cast<std::uint8_t>(std::clamp(brightness, 0.0, 1.0) * 255);
    return {value, value, value};
}

double fraction(std::int64_t value, MapRange range) {
    return range.most == range.least ? 1.0
                                     : static_cast<double>(value - range.least) /
                                           static_cast<double>(range.most - range.least);
}

Rgb8 normal_color(std::int64_t value) {
    const auto component = [&](unsigned k) {
        const int field = static_cast<int>(value >> (10 * k) & 0x3FF);
        return (field < 512 ? field : field - 1024) / double{isa::region::normal_unit};
    };
    return directional(component(0), component(1), component(2));
}

/// True for background and for a pixel that no primitive reached.
bool is_plain(MapKind kind, std::int64_t value) {
    return value == no_value ||
           (value == 0 && (kind == MapKind::covered || kind == MapKind::overdraw));
}

/// light  Brightness of the picture at that pixel, 0..1.
Rgb8 color_of(const MapValues& map, MapRange range, std::size_t i, double light) {
    const std::int64_t value = map.values[i];
    if (is_plain(map.kind, value)) {
        return gray(background_part * light);
    }
    switch (info(map.kind).scale) {
        case MapScale::count:
            return mix(gray(light), sequential(fraction(value, range)), map_part);
        case MapScale::category:  // The picture's shading keeps the shape visible.
            return mix(Rgb8{}, categorical(static_cast<std::uint32_t>(value)), 0.4 + 0.6 * light);
        case MapScale::direction:
            return normal_color(value);
    }
    return {};
}

MarkColor mark_color(Rgb8 color) {
    return {color.r, color.g, color.b, 255};
}

/// The legend while it is drawn; `y` is where the next row begins.
struct Legend {
    const MapValues& map;
    MapRange range;
    double px;  ///< Font size.
    Chart chart;
    double y = 0;

    double margin() const { return px * 0.6; }
    double row() const { return px * 1.45; }
    double length() const { return chart.width - 2 * margin(); }
    void text(double x, const std::string& text, MarkColor color, float align_x = 0) {
        chart.text({x, y + px}, text, {.size_px = px, .align_x = align_x, .color = color});
    }
};

/// Writes the title, and the subject at the right, on a line of its own if both are too wide.
void draw_title(Legend& legend, const std::string& subject) {
    const MapInfo& kind = info(legend.map.kind);
    const std::string title = fmt::format("{}: {}{}", kind.title, kind.unit,
                                          is_plain(legend.map.kind, 0) ? " (gray: none)" : "");
    legend.y = legend.margin();
    double used = 0;
    for (const std::string& line : broken(title, legend.length(), legend.px)) {
        legend.text(legend.margin(), line, ink);
        used = text_width(line + "  ", legend.px);
        legend.y += legend.row();
    }
    if (used + text_width(subject, legend.px) <= legend.length()) {
        legend.y -= legend.row();
    }
    legend.text(legend.chart.width - legend.margin(), subject, dim_ink, 1);
    legend.y += subject.empty() && used == 0 ? 0 : legend.row();
}

void draw_bar(Legend& legend) {
    constexpr int steps = 128;
    const double left = legend.margin(), right = left + legend.length();
    const double bottom = legend.y + legend.px;
    // Each step reaches to the right end, so that no gap shows between neighbors.
    for (int step = 0; step < steps; ++step) {
        legend.chart.area(
            {std::round(left + legend.length() * step / steps), legend.y, right, bottom},
            mark_color(sequential(step / double(steps - 1))));
    }
    // Small ranges get one tick per number.
    const std::int64_t span = legend.range.most - legend.range.least;
    const int ticks = span == 0 ? 1 : static_cast<int>(std::min<std::int64_t>(span + 1, bar_ticks));
    legend.y = bottom + legend.px * 0.3;
    for (int tick = 0; tick < ticks; ++tick) {
        const double part = ticks == 1 ? 1.0 : tick / double(ticks - 1);
        const std::int64_t value =
            legend.range.least + static_cast<std::int64_t>(part * static_cast<double>(span) + 0.5);
        // The tick is at the rounded number.
        const double x = left + fraction(value, legend.range) * legend.length();
        legend.chart.line({x, bottom}, {x, bottom + legend.px * 0.3}, ink, legend.px / 12);
        const float align = part == 0 ? 0 : part == 1 ? 1 : 0.5F;
        legend.text(x, short_number(value), ink, align);
    }
    legend.y += legend.row();
}

void draw_swatches(Legend& legend) {
    std::set<std::int64_t> categories(legend.map.values.begin(), legend.map.values.end());
    categories.erase(no_value);
    const std::string unit(info(legend.map.kind).unit);
    const double width = text_width(unit + " 99", legend.px) + 3 * legend.px;
    const auto columns = static_cast<std::size_t>(std::max(1.0, legend.length() / width));
    std::size_t place = 0;
    for (const std::int64_t category : categories) {
        if (place == most_swatches) {
            break;
        }
        legend.y += place > 0 && place % columns == 0 ? legend.row() : 0;
        const double x = legend.margin() + static_cast<double>(place % columns) * width;
        legend.chart.area(
            {x, legend.y + legend.px * 0.2, x + legend.px * 0.9, legend.y + legend.px * 1.1},
            mark_color(categorical(static_cast<std::uint32_t>(category))));
        legend.text(x + legend.px * 1.3, fmt::format("{} {}", unit, category), ink);
        ++place;
    }
    legend.y += legend.row();
}

/// The whole legend; its top left corner is (0, 0).
Chart draw_legend(const MapValues& map, const std::string& subject, int width) {
    Legend legend{map, range_of(map), width >= large_width_px ? 16.0 : 11.0, {}, 0};
    legend.chart.width = width;
    legend.chart.line({0, 0.5}, {legend.chart.width, 0.5}, frame_line);
    draw_title(legend, subject);
    switch (info(map.kind).scale) {
        case MapScale::count:
            draw_bar(legend);
            break;
        case MapScale::category:
            draw_swatches(legend);
            break;
        case MapScale::direction:
            legend.text(legend.margin(), "red x right, green y up, blue z to the viewer", ink);
            legend.y += legend.row();
    }
    legend.chart.height = std::ceil(legend.y + legend.margin() / 2);
    return std::move(legend.chart);
}

/// Draws the regions' borders. Views are stacked, and each begins with whole regions.
void draw_grid(Chart& chart, const MapValues& map, double left) {
    const double right = left + map.width;
    for (int x = region_px; x < map.width; x += region_px) {
        chart.line({left + x + 0.5, 0}, {left + x + 0.5, double(map.height)}, grid_line);
    }
    for (int y = region_px; y < map.height; y += region_px) {
        chart.line({left, y + 0.5}, {right, y + 0.5}, grid_line);
    }
}

/// Writes each region's number into its corner.
void label_regions(Chart& chart, const MapValues& map, int left) {
    constexpr float inset_px = 5, halo_px = 2;
    const float height_px = map.width >= 2 * region_px ? 18 : 12;
    for (int y = 0; y < map.height; y += region_px) {
        for (int x = 0; x < map.width; x += region_px) {
            if (const std::int64_t value = map.values[at(x, y, map.width)]; value != no_value) {
                chart.marks.push_back(text_mark(
                    {static_cast<float>(left + x) + inset_px, static_cast<float>(y) + inset_px},
                    short_number(value), ink, {height_px, 0, 0, halo_px}));
            }
        }
    }
}

}  // namespace

std::string short_number(std::int64_t value) {
    if (value < 10'000) {
        return fmt::format("{}", value);
    }
    const bool millions = value >= 1'000'000;
    return fmt::format("{:.4g}{}", static_cast<double>(value) / (millions ? 1e6 : 1e3),
                       millions ? 'M' : 'k');
}

MapRange range_of(const MapValues& map) {
    bool any = false;
    MapRange range;
    for (const std::int64_t value : map.values) {
        if (!is_plain(map.kind, value)) {
            range.least = any ? std::min(range.least, value) : value;
            range.most = any ? std::max(range.most, value) : value;
            any = true;
        }
    }
    return range;
}

MapPicture draw_map(const MapValues& map, const MapStyle& style) {
    const int width = std::max(map.width, least_width_px), left = (width - map.width) / 2;
    const Chart legend = draw_legend(map, style.subject, width);
    const int height = map.height + static_cast<int>(legend.height);
    MapPicture picture{
        width, height, std::vector<std::uint32_t>(at(0, height, width), paper.opaque()), {}};
    const MapRange range = range_of(map);
    double brightest = 1.0 / 255;
    for (const std::uint32_t pixel : map.picture) {
        brightest = std::max(brightest, luminance(pixel));
    }
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const std::size_t i = at(x, y, map.width);
            picture.rgba[at(left + x, y, width)] =
                color_of(map, range, i, luminance(map.picture[i]) / brightest).opaque();
        }
    }
    Chart chart;
    if (style.grid) {
        draw_grid(chart, map, left);
    }
    if (info(map.kind).per_region) {
        label_regions(chart, map, left);
    }
    chart.place(legend, {0, double(map.height)});
    picture.marks = std::move(chart.marks);
    return picture;
}

}  // namespace pxpl5::host::inspect
