// The only file that includes cairo and FreeType.
#include "host/io/picture/draw_marks.hpp"

#include <cairo-ft.h>
#include <cairo-pdf.h>
#include <cairo-svg.h>
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

/// Part of the color's opacity that its halo has.
constexpr double halo_opacity = 0.7;
/// A pixel of a document is 1/96 inch, a point 1/72 inch.
constexpr double pdf_points_per_px = 0.75;

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

void set_color(cairo_t* context, const MarkColor& c, double opacity = 1) {
    cairo_set_source_rgba(context, c.r / 255.0, c.g / 255.0, c.b / 255.0, c.a / 255.0 * opacity);
}

bool is_light(const MarkColor& c) {
    return 0.299 * c.r + 0.587 * c.g + 0.114 * c.b >= 128;
}

void draw_outline(cairo_t* context, const PictureMark& mark) {
    cairo_new_path(context);
    for (const glm::vec2& p : mark.points) {
        cairo_line_to(context, p.x, p.y);
    }
    set_color(context, mark.color);
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
    const bool is_vector =
        cairo_surface_get_type(cairo_get_target(context)) != CAIRO_SURFACE_TYPE_IMAGE;
    if (is_vector && mark.width_px == 0) {
        set_color(context, mark.color);
        cairo_show_text(context, line.c_str());  // The document refers to the font's glyphs.
        return;
    }
    cairo_text_path(context, line.c_str());
    if (mark.width_px > 0) {
        const MarkColor halo =
            is_light(mark.color) ? MarkColor{0, 0, 0, 255} : MarkColor{255, 255, 255, 255};
        set_color(context, {halo.r, halo.g, halo.b, mark.color.a}, halo_opacity);
        cairo_set_line_width(context, 2.0 * mark.width_px);  // Half of it is under the letters.
        cairo_stroke_preserve(context);
    }
    set_color(context, mark.color);
    cairo_fill(context);
}

/// value * alpha / 255, rounded.
std::uint32_t scaled(std::uint32_t value, std::uint32_t alpha) {
    return (value * alpha + 127) / 255;
}

/// Draws `marks` in their order.
void draw_all(cairo_t* context, const Font& font, std::span<const PictureMark> marks) {
    if (marks.size() > max_marks) {
        throw MarkError(fmt::format("{} marks, at most {}", marks.size(), max_marks));
    }
    cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
    cairo_set_font_face(context, font.cairo_face.get());
    const Options options(cairo_font_options_create());
    cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(context, options.get());
    for (std::size_t index = 0; index < marks.size(); ++index) {
        check(marks[index], index);
        if (marks[index].kind == MarkKind::text) {
            draw_text(context, marks[index]);
        } else {
            draw_outline(context, marks[index]);
        }
        if (const cairo_status_t status = cairo_status(context); status != CAIRO_STATUS_SUCCESS) {
            throw MarkError(fmt::format("{}: {}", name_of(marks[index], index),
                                        cairo_status_to_string(status)));
        }
    }
}

/// Fills the document with the pixels: with their color if all have the same, else as an image.
void paint_pixels(cairo_t* context, const DocumentContent& content) {
    const std::span<const std::uint8_t> rgba = content.rgba;
    if (std::equal(rgba.begin() + 4, rgba.end(), rgba.begin())) {
        set_color(context, {rgba[0], rgba[1], rgba[2], rgba[3]});
        cairo_paint(context);
        return;
    }
    MarkLayer image{content.width, content.height, std::vector<std::uint8_t>(rgba.size())};
    for (std::size_t at = 0; at < rgba.size(); at += 4) {
        const std::uint32_t alpha = rgba[at + 3];
        for (std::size_t channel = 0; channel < 3; ++channel) {
            image.bgra[at + 2 - channel] =
                static_cast<std::uint8_t>(scaled(rgba[at + channel], alpha));
        }
        image.bgra[at + 3] = static_cast<std::uint8_t>(alpha);
    }
    const Surface surface(cairo_image_surface_create_for_data(
        image.bgra.data(), CAIRO_FORMAT_ARGB32, image.width, image.height, 4 * image.width));
    cairo_set_source_surface(context, surface.get(), 0, 0);
    cairo_pattern_set_filter(cairo_get_source(context), CAIRO_FILTER_NEAREST);
    cairo_paint(context);
    cairo_set_source_rgb(context, 0, 0, 0);
    // The document's copy of the pixels is made when `surface` is released, before `image` is.
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned length) {
    static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
}

std::string xml_text(const std::string& text) {
    std::string safe;
    for (const char c : text) {
        switch (c) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            default:
                safe += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
        }
    }
    return safe;
}

/// The description and all texts, for search and for screen readers: the letters are drawn as
/// shapes.
std::string description_element(const DocumentContent& content) {
    std::string texts;
    for (const PictureMark& mark : content.marks) {
        texts += mark.text.empty() ? "" : xml_text(mark.text) + "\n";
    }
    return fmt::format("<title>{}</title>\n<desc>{}</desc>\n", xml_text(content.description),
                       texts);
}

}  // namespace

MarkLayer draw_marks(std::span<const PictureMark> marks, int width, int height) {
    const auto bytes = 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    MarkLayer layer{width, height, std::vector<std::uint8_t>(bytes)};
    assert(cairo_format_stride_for_width(CAIRO_FORMAT_ARGB32, width) == 4 * width);
    const Font font = load_font();
    const Surface surface(cairo_image_surface_create_for_data(
        layer.bgra.data(), CAIRO_FORMAT_ARGB32, width, height, 4 * width));
    const Context context(cairo_create(surface.get()));
    draw_all(context.get(), font, marks);
    cairo_surface_flush(surface.get());
    return layer;
}

std::string draw_document(DocumentFormat format, const DocumentContent& content) {
    const double unit = format == DocumentFormat::pdf ? pdf_points_per_px : 1;
    const double width = content.width * unit, height = content.height * unit;
    std::string bytes;
    const Font font = load_font();  // A document reads its glyphs at its end.
    const Surface surface(format == DocumentFormat::pdf
                              ? cairo_pdf_surface_create_for_stream(append, &bytes, width, height)
                              : cairo_svg_surface_create_for_stream(append, &bytes, width, height));
    if (format == DocumentFormat::pdf) {
        cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE,
                                       content.description.c_str());
    } else {
        cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PX);
    }
    const Context context(cairo_create(surface.get()));
    cairo_scale(context.get(), unit, unit);
    paint_pixels(context.get(), content);
    draw_all(context.get(), font, content.marks);
    cairo_surface_finish(surface.get());
    if (const cairo_status_t status = cairo_surface_status(surface.get());
        status != CAIRO_STATUS_SUCCESS) {
        throw MarkError(cairo_status_to_string(status));
    }
    if (format == DocumentFormat::svg) {
        const std::size_t head = bytes.find(">\n", bytes.find("<svg "));
        bytes.insert(head + 2, description_element(content));
    }
    return bytes;
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
