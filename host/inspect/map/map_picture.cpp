#include "host/inspect/map/map_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "host/inspect/map/map_colours.hpp"
#include "host/inspect/map/pixel_font.hpp"
#include "isa/contract/region_layout.hpp"

namespace pxpl5::host::inspect {

namespace {

constexpr Rgb8 paper{24, 24, 28}, ink{235, 235, 235}, dim_ink{150, 150, 155}, line{90, 90, 98};
constexpr int least_width_px = 336;       ///< Narrower pictures get a margin: a legend needs room.
constexpr int large_width_px = 640;       ///< From here on the legend's letters are doubled.
constexpr double map_part = 0.8;          ///< Of a count's colour over the grey picture.
constexpr double background_part = 0.35;  ///< Of the grey picture where there is no value.
constexpr int bar_ticks = 5;
constexpr std::size_t most_swatches = 64;  ///< More categories are not explained one by one.

std::size_t at(int x, int y, int width) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
}

/// Brightness of a drawn pixel, 0..1.
double luminance(std::uint32_t rgb) {
    return (0.2126 * (rgb & 0xFF) + 0.7152 * (rgb >> 8 & 0xFF) + 0.0722 * (rgb >> 16 & 0xFF)) / 255;
}

Rgb8 grey(double brightness) {
    const auto value = static_cast<std::uint8_t>(std::clamp(brightness, 0.0, 1.0) * 255);
    return {value, value, value};
}

double fraction(std::int64_t value, MapRange range) {
    return range.most == range.least ? 1.0
                                     : static_cast<double>(value - range.least) /
                                           static_cast<double>(range.most - range.least);
}

Rgb8 normal_colour(std::int64_t value) {
    const auto component = [&](unsigned k) {
        const int field = static_cast<int>(value >> (10 * k) & 0x3FF);
        return (field < 512 ? field : field - 1024) / double{isa::region::normal_unit};
    };
    return directional(component(0), component(1), component(2));
}

/// Nothing is said of the pixel: background, or no primitive came there.
bool is_plain(MapKind kind, std::int64_t value) {
    return value == no_value ||
           (value == 0 && (kind == MapKind::covered || kind == MapKind::overdraw));
}

/// light  Of the picture there, 0..1.
Rgb8 colour_of(const MapValues& map, MapRange range, std::size_t i, double light) {
    const std::int64_t value = map.values[i];
    if (is_plain(map.kind, value)) {
        return grey(background_part * light);
    }
    switch (info(map.kind).scale) {
        case MapScale::count:
            return mix(grey(light), sequential(fraction(value, range)), map_part);
        case MapScale::category:  // Shaded by the picture, so that its shape stays visible.
            return mix(Rgb8{}, categorical(static_cast<std::uint32_t>(value)), 0.4 + 0.6 * light);
        case MapScale::direction:
            return normal_colour(value);
    }
    return {};
}

/// A picture that can be drawn on.
class Canvas {
  public:
    Canvas(int width, int height) : width_(width), height_(height) {
        pixels_.assign(at(0, height, width), paper.opaque());
    }
    void put(int x, int y, Rgb8 colour) {
        if (x >= 0 && x < width_ && y >= 0 && y < height_) {
            pixels_[at(x, y, width_)] = colour.opaque();
        }
    }
    void fill(int x0, int y0, int width, int height, Rgb8 colour) {
        for (int y = y0; y < y0 + height; ++y) {
            for (int x = x0; x < x0 + width; ++x) {
                put(x, y, colour);
            }
        }
    }
    void text(int x, int y, const std::string& text, int scale, Rgb8 colour) {
        for (const char c : text) {
            const auto rows = glyph(c);
            for (int row = 0; row < glyph_height; ++row) {
                for (int column = 0; column < glyph_width; ++column) {
                    if ((rows[static_cast<std::size_t>(row)] >> (glyph_width - 1 - column) & 1) !=
                        0) {
                        fill(x + column * scale, y + row * scale, scale, scale, colour);
                    }
                }
            }
            x += glyph_advance * scale;
        }
    }
    MapPicture take() && { return {width_, height_, std::move(pixels_)}; }

  private:
    int width_, height_;
    std::vector<std::uint32_t> pixels_;
};

int text_width(const std::string& text, int scale) {
    return static_cast<int>(text.size()) * glyph_advance * scale;
}

/// The legend's texts and places.
class Legend {
  public:
    Legend(const MapValues& map, const MapStyle& style, int width)
        : map_(map), range_(range_of(map)), width_(width), scale_(width >= large_width_px ? 2 : 1) {
        const MapInfo& kind = info(map.kind);
        title_ = fmt::format("{}: {}{}", kind.title, kind.unit,
                             is_plain(map.kind, 0) ? " (grey: none)" : "");
        if (!style.subject.empty()) {
            subject_ = style.subject;
        }
        if (kind.scale == MapScale::category) {
            for (const std::int64_t value : map.values) {
                if (value != no_value) {
                    categories_.insert(value);
                }
            }
        }
    }

    int height() const {
        switch (info(map_.kind).scale) {
            case MapScale::count:
                return title_height() + 5 * line_height() / 2;
            case MapScale::category:
                return title_height() + swatch_rows() * line_height() + margin();
            case MapScale::direction:
                return title_height() + line_height() + margin();
        }
        return 0;
    }

    void draw(Canvas& canvas, int top) const {
        canvas.fill(0, top, width_, 1, line);
        canvas.text(margin(), top + margin(), title_, scale_, ink);
        const int right = width_ - margin() - text_width(subject_, scale_);
        canvas.text(is_title_broken() ? margin() : right,
                    top + margin() + (is_title_broken() ? line_height() : 0), subject_, scale_,
                    dim_ink);
        const int below = top + title_height();
        switch (info(map_.kind).scale) {
            case MapScale::count:
                return draw_bar(canvas, below);
            case MapScale::category:
                return draw_swatches(canvas, below);
            case MapScale::direction:
                return canvas.text(margin(), below, "red x right, green y up, blue z to the viewer",
                                   scale_, ink);
        }
    }

  private:
    int margin() const { return 6 * scale_; }
    int line_height() const { return (glyph_height + 4) * scale_; }
    bool is_title_broken() const {
        return text_width(title_ + "  " + subject_, scale_) > width_ - 2 * margin();
    }
    int title_height() const {
        return margin() + (is_title_broken() ? 2 : 1) * line_height() + 2 * scale_;
    }

    void draw_bar(Canvas& canvas, int top) const {
        const int x0 = margin(), length = width_ - 2 * margin(), thick = line_height();
        for (int x = 0; x < length; ++x) {
            canvas.fill(x0 + x, top, 1, thick, sequential(x / double(length - 1)));
        }
        // Small ranges get a tick per number.
        const std::int64_t span = range_.most - range_.least;
        const int ticks =
            span == 0 ? 1 : static_cast<int>(std::min<std::int64_t>(span + 1, bar_ticks));
        for (int tick = 0; tick < ticks; ++tick) {
            const double part = ticks == 1 ? 1.0 : tick / double(ticks - 1);
            const std::int64_t value =
                range_.least + static_cast<std::int64_t>(part * static_cast<double>(span) + 0.5);
            // A rounded number stands where it belongs, not where the tick would be.
            const int x = static_cast<int>(fraction(value, range_) * (length - 1));
            canvas.fill(x0 + x - (x == length - 1 ? scale_ - 1 : 0), top + thick, scale_,
                        2 * scale_, ink);
            const std::string text = short_number(value);
            const int half = text_width(text, scale_) / 2;
            canvas.text(std::clamp(x0 + x - half, x0, x0 + length - 2 * half + scale_),
                        top + thick + 4 * scale_, text, scale_, ink);
        }
    }

    std::string swatch_text(std::int64_t category) const {
        return fmt::format("{} {}", info(map_.kind).unit, category);
    }
    int swatch_width() const {
        return text_width(swatch_text(99), scale_) + line_height() + margin();
    }
    int swatches_a_row() const { return std::max(1, (width_ - margin()) / swatch_width()); }
    int swatch_rows() const {
        const int count = static_cast<int>(std::min(categories_.size(), most_swatches));
        return std::max(1, (count + swatches_a_row() - 1) / swatches_a_row());
    }
    void draw_swatches(Canvas& canvas, int top) const {
        int place = 0;
        for (const std::int64_t category : categories_) {
            if (place == static_cast<int>(most_swatches)) {
                break;
            }
            const int x = margin() + place % swatches_a_row() * swatch_width();
            const int y = top + place / swatches_a_row() * line_height();
            const int side = glyph_height * scale_;
            canvas.fill(x, y, side, side, categorical(static_cast<std::uint32_t>(category)));
            canvas.text(x + side + 3 * scale_, y, swatch_text(category), scale_, ink);
            ++place;
        }
    }

    const MapValues& map_;
    MapRange range_;
    int width_, scale_;
    std::string title_, subject_;
    std::set<std::int64_t> categories_;
};

/// Regions' borders, lightened; a view of another height than whole regions begins anew.
void draw_grid(Canvas& canvas, const MapValues& map, const std::vector<Rgb8>& colours, int x0) {
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            if ((x % isa::region::size_px == 0 && x > 0) ||
                (y % isa::region::size_px == 0 && y > 0)) {
                canvas.put(x0 + x, y, mix(colours[at(x, y, map.width)], ink, 0.4));
            }
        }
    }
}

/// Writes each region's number into its corner.
void label_regions(Canvas& canvas, const MapValues& map, int x0) {
    constexpr int inset = 5;
    const int scale = map.width >= 2 * isa::region::size_px ? 2 : 1;
    for (int y = 0; y < map.height; y += isa::region::size_px) {
        for (int x = 0; x < map.width; x += isa::region::size_px) {
            const std::int64_t value = map.values[at(x, y, map.width)];
            if (value != no_value) {
                const std::string text = short_number(value);
                canvas.text(x0 + x + inset + 1, y + inset + 1, text, scale, Rgb8{});
                canvas.text(x0 + x + inset, y + inset, text, scale, ink);
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
    const int width = std::max(map.width, least_width_px);
    const int x0 = (width - map.width) / 2;
    const Legend legend(map, style, width);
    Canvas canvas(width, map.height + legend.height());
    const MapRange range = range_of(map);
    std::vector<Rgb8> colours(map.values.size());
    double brightest = 1.0 / 255;
    for (const std::uint32_t pixel : map.picture) {
        brightest = std::max(brightest, luminance(pixel));
    }
    for (std::size_t i = 0; i < colours.size(); ++i) {
        colours[i] = colour_of(map, range, i, luminance(map.picture[i]) / brightest);
        const int column = static_cast<int>(i % static_cast<std::size_t>(map.width));
        const int row = static_cast<int>(i / static_cast<std::size_t>(map.width));
        canvas.put(x0 + column, row, colours[i]);
    }
    if (style.grid) {
        draw_grid(canvas, map, colours, x0);
    }
    if (info(map.kind).per_region) {
        label_regions(canvas, map, x0);
    }
    legend.draw(canvas, map.height);
    return std::move(canvas).take();
}

}  // namespace pxpl5::host::inspect
