// Draws marks over pictures: anti-aliased, with one font, the same pixels on every machine with the
// same cairo.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "generated/vocabulary.hpp"
#include "host/scene/marks.hpp"

namespace pxpl5::host::io {

/// Debian's fonts-dejavu-core. The file itself, so that no font configuration has a say.
inline constexpr const char* mark_font_file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

inline constexpr float max_font_px = 2'000;
inline constexpr float max_line_px = 2'000;

/// Thrown for marks that cannot be drawn. `what` names the mark and the reason.
struct MarkError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Marks on a transparent background: display-coded values multiplied by their alpha.
struct MarkLayer {
    int width = 0, height = 0;
    std::vector<std::uint8_t> bgra;  ///< width * height * 4, top row first; alpha multiplied in.
};

/// Draws `marks` in their order. What lies outside of the picture is cut off. A letter that the
/// font does not have is an empty box.
/// Throws   MarkError: too few points, numbers that are not finite or beyond the limits above, a
///          text that is not UTF-8, a missing font.
MarkLayer draw_marks(std::span<const PictureMark> marks, int width, int height);

/// A picture without pixels of its own: lines and letters stay sharp at any size.
enum class DocumentFormat : std::uint8_t { svg, pdf };

struct DocumentContent {
    int width = 0, height = 0;           ///< Pixels of 1/96 inch.
    std::span<const std::uint8_t> rgba;  ///< width * height * 4, alpha not multiplied in.
    std::span<const PictureMark> marks;  ///< Drawn over the pixels.
    std::string description;             ///< UTF-8; the document's title.
};

/// Returns the file's bytes. Throws MarkError as draw_marks() does.
std::string draw_document(DocumentFormat format, const DocumentContent& content);

/// Lays the layer over one picture of its size. Pixels without marks keep their bits.
///
/// rgba   width * height * 4, alpha not multiplied in.
void lay_over(const MarkLayer& layer, std::span<std::uint8_t> rgba);

}  // namespace pxpl5::host::io
