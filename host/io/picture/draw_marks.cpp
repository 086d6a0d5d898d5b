// The only file that includes cairo and FreeType.
#include "host/io/picture/draw_marks.hpp"

#include <cairo-ft.h>
#include <cairo.h>
#include <fmt/format.h>
#include <ft2build.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <string>

namespace pxpl5::host::io {

namespace {

/// Part of the colour's opacity that its halo has.
constexpr double halo_opacity = 0.7;

template <auto release>
struct Release {
    template <typename T>
    void operator()(T* thing) const {
        release(thing);
    }
};
using Surface = std::unique_ptr<cairo_surface_t, Release<cairo_surface_destroy>>;
using Context = std::unique_ptr<cairo_t, Release<cairo_destroy>>;
using Options = std::unique_ptr<cairo_font_options_t, Release<cairo_font_options_destroy>>;
using Library = std::unique_ptr<FT_LibraryRec_, Release<FT_Done_FreeType>>;
using Face = std::unique_ptr<FT_FaceRec_, Release<FT_Done_Face>>;
using FontFace = std::unique_ptr<cairo_font_face_t, Release<cairo_font_face_destroy>>;

/// The font. Cairo keeps no hold of FreeType's face, so members go in reverse order.
struct Font {
    Library library;
    Face face;
    FontFace cairo_face;
};

Font load_font() {
    FT_Library library = nullptr;
    if (FT_Init_FreeType(&library) != 0) {
        throw MarkError("FreeType cannot be started");
    }
    Font font;
    font.library.reset(library);
    FT_Face face = nullptr;
    if (FT_New_Face(library, mark_font_file, 0, &face) != 0) {
        throw MarkError(fmt::format(
            "texts need the font {}, which cannot be read; it is in the package fonts-dejavu-core",
            mark_font_file));
    }
    font.face.reset(face);
    font.cairo_face.reset(cairo_ft_font_face_create_for_ft_face(face, FT_LOAD_NO_HINTING));
    return font;
}

std::string name_of(const PictureMark& mark, std::size_t index) {
    const char* kind = mark.kind == MarkKind::line   ? "line"
                       : mark.kind == MarkKind::area ? "area"
                                                     : "text";
    return fmt::format("mark {} ({}{})", index, kind, mark.text.empty() ? "" : " " + mark.text);
}

/// Whether the number is finite and in [low, high].
bool within(float value, float low, float high) {
    return value >= low && value <= high;
}

void check(const PictureMark& mark, std::size_t index) {
    const std::size_t least = mark.kind == MarkKind::line ? 2 : mark.kind == MarkKind::area ? 3 : 1;
    if (mark.points.size() < least) {
        throw MarkError(fmt::format("{} has {} points, needs {}", name_of(mark, index),
                                    mark.points.size(), least));
    }
    for (const glm::vec2& p : mark.points) {
        if (!within(p.x, -max_mark_px, max_mark_px) || !within(p.y, -max_mark_px, max_mark_px)) {
            throw MarkError(fmt::format("{} has a point at ({}, {}), must be within {} pixels",
                                        name_of(mark, index), p.x, p.y, max_mark_px));
        }
    }
    if (!within(mark.width_px, 0, max_line_px)) {
        throw MarkError(fmt::format("{} is {} pixels wide, must be 0 to {}", name_of(mark, index),
                                    mark.width_px, max_line_px));
    }
    if (mark.kind == MarkKind::text &&
        (!within(mark.height_px, 1, max_font_px) || !within(mark.align_x, 0, 1) ||
         !within(mark.align_y, 0, 1))) {
        throw MarkError(fmt::format("{} is {} pixels high (1 to {}), aligned at ({}, {}) (0 to 1)",
                                    name_of(mark, index), mark.height_px, max_font_px, mark.align_x,
                                    mark.align_y));
    }
}

void set_colour(cairo_t* context, const MarkColour& c, double opacity = 1) {
    cairo_set_source_rgba(context, c.r / 255.0, c.g / 255.0, c.b / 255.0, c.a / 255.0 * opacity);
}

bool is_light(const MarkColour& c) {
    return 0.299 * c.r + 0.587 * c.g + 0.114 * c.b >= 128;
}

void draw_outline(cairo_t* context, const PictureMark& mark) {
    cairo_new_path(context);
    for (const glm::vec2& p : mark.points) {
        cairo_line_to(context, p.x, p.y);
    }
    set_colour(context, mark.colour);
    if (mark.kind == MarkKind::area) {
        cairo_close_path(context);
        cairo_fill(context);
    } else {
        cairo_set_line_width(context, mark.width_px);
        cairo_stroke(context);
    }
}

void draw_text(cairo_t* context, const PictureMark& mark) {
    std::string line = mark.text;
    std::replace_if(
        line.begin(), line.end(), [](unsigned char c) { return c < ' '; }, ' ');
    cairo_set_font_size(context, mark.height_px);
    cairo_text_extents_t text;
    cairo_font_extents_t font;
    cairo_text_extents(context, line.c_str(), &text);
    cairo_font_extents(context, &font);
    const double x = mark.points[0].x - mark.align_x * text.x_advance;
    const double y = mark.points[0].y + font.ascent - mark.align_y * (font.ascent + font.descent);
    cairo_new_path(context);
    cairo_move_to(context, x, y);
    cairo_text_path(context, line.c_str());
    if (mark.width_px > 0) {
        const MarkColour halo =
            is_light(mark.colour) ? MarkColour{0, 0, 0, 255} : MarkColour{255, 255, 255, 255};
        set_colour(context, {halo.r, halo.g, halo.b, mark.colour.a}, halo_opacity);
        cairo_set_line_width(context, 2.0 * mark.width_px);  // Half of it is under the letters.
        cairo_stroke_preserve(context);
    }
    set_colour(context, mark.colour);
    cairo_fill(context);
}

/// value * alpha / 255, rounded.
std::uint32_t scaled(std::uint32_t value, std::uint32_t alpha) {
    return (value * alpha + 127) / 255;
}

}  // namespace

MarkLayer draw_marks(std::span<const PictureMark> marks, int width, int height) {
    if (marks.size() > max_marks) {
        throw MarkError(fmt::format("{} marks, at most {}", marks.size(), max_marks));
    }
    const auto bytes = 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    MarkLayer layer{width, height, std::vector<std::uint8_t>(bytes)};
    assert(cairo_format_stride_for_width(CAIRO_FORMAT_ARGB32, width) == 4 * width);
    const Font font = load_font();
    const Surface surface(cairo_image_surface_create_for_data(
        layer.bgra.data(), CAIRO_FORMAT_ARGB32, width, height, 4 * width));
    const Context context(cairo_create(surface.get()));
    cairo_set_line_join(context.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_set_font_face(context.get(), font.cairo_face.get());
    const Options options(cairo_font_options_create());
    cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(context.get(), options.get());
    for (std::size_t index = 0; index < marks.size(); ++index) {
        check(marks[index], index);
        if (marks[index].kind == MarkKind::text) {
            draw_text(context.get(), marks[index]);
        } else {
            draw_outline(context.get(), marks[index]);
        }
        if (const cairo_status_t status = cairo_status(context.get());
            status != CAIRO_STATUS_SUCCESS) {
            throw MarkError(fmt::format("{}: {}", name_of(marks[index], index),
                                        cairo_status_to_string(status)));
        }
    }
    cairo_surface_flush(surface.get());
    return layer;
}

void lay_over(const MarkLayer& layer, std::span<std::uint8_t> rgba) {
    assert(rgba.size() == layer.bgra.size());
    for (std::size_t at = 0; at < rgba.size(); at += 4) {
        const std::uint8_t* mark = &layer.bgra[at];
        std::uint8_t* pixel = &rgba[at];
        const std::uint32_t below = scaled(pixel[3], 255U - mark[3]);  // What of it is still seen.
        const std::uint32_t alpha = mark[3] + below;
        if (mark[3] == 0) {
            continue;
        }
        for (std::size_t channel = 0; channel < 3; ++channel) {
            const std::uint32_t sum =
                255U * mark[2 - channel] + below * pixel[channel];  // Times 255.
            pixel[channel] =
                static_cast<std::uint8_t>(std::min((sum + alpha / 2) / alpha, std::uint32_t{255}));
        }
        pixel[3] = static_cast<std::uint8_t>(alpha);
    }
}

}  // namespace pxpl5::host::io
