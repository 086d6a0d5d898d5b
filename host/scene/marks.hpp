// Marks over a picture: lines, filled areas and texts, in pixels.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "generated/vocabulary.hpp"

namespace pxpl5::host {

struct MarkColor {
    std::uint8_t r = 255, g = 255, b = 255;
    std::uint8_t a = 255;  ///< 255 hides what is below.
    friend bool operator==(const MarkColor&, const MarkColor&) = default;
};

/// One mark, as the io process draws it. Points are pixels from the picture's top left corner, x to
/// the right and y downwards; the middle of the first pixel is (0.5, 0.5).
struct PictureMark {
    MarkKind kind = MarkKind::line;
    std::vector<glm::vec2>
        points;  ///< An open line's 2 or more, a polygon's 3 or more, a text's 1.
    MarkColor color;
    /// Width of a line or of a text's halo, which is black around light letters, white around dark
    /// ones so that they can be read over anything, and 0 for none.
    float width_px = 1;
    std::string text;      ///< UTF-8, one line.
    float height_px = 12;  ///< Font size.
    float align_x = 0;     ///< Place of the point in the text's box: 0 left, 0.5 middle, 1 right.
    float align_y = 0;     ///< 0 top edge, 0.5 middle, 1 bottom.
};

inline PictureMark line_mark(std::vector<glm::vec2> points, MarkColor color, float width_px) {
    return {MarkKind::line, std::move(points), color, width_px, "", 12, 0, 0};
}

inline PictureMark area_mark(std::vector<glm::vec2> points, MarkColor color) {
    return {MarkKind::area, std::move(points), color, 0, "", 12, 0, 0};
}

/// How a text stands: its size, its place at its point, and its halo.
struct TextStyle {
    float height_px = 12;
    float align_x = 0, align_y = 0;
    float halo_px = 0;
};

inline PictureMark text_mark(glm::vec2 at, std::string text, MarkColor color, TextStyle style) {
    return {MarkKind::text,  {at},          color,        style.halo_px, std::move(text),
            style.height_px, style.align_x, style.align_y};
}

}  // namespace pxpl5::host
