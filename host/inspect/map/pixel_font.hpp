// Capital letters, digits and signs of 5 x 7 pixels, for legends inside of pictures.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace pxpl5::host::inspect {

inline constexpr int glyph_width = 5, glyph_height = 7;
inline constexpr int glyph_advance = glyph_width + 1;

/// Rows of a character from the top, five bits each, the leftmost highest. Small letters are
/// capital; what the font lacks is blank.
std::array<std::uint8_t, glyph_height> glyph(char c);

}  // namespace pxpl5::host::inspect
