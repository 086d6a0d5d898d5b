// Stipple (screen-door) transparency: the fields of a pixel while a transparent surface is drawn.
//
// A transparent surface appears in some pixels of each 4 x 4 group. In the other pixels the door is
// shut: the program saves their depth and stores the nearest depth, so that no triangle passes the
// depth test. Opening the door restores the depth. The saved depth uses rgb, which holds only the
// color of the background until the end of the region; that color is written again.
#pragma once

#include "isa/contract/region_layout.hpp"

namespace pxpl5::isa::door {

inline constexpr std::uint32_t levels =
    16;  ///< Levels of opacity; a surface with all levels is opaque.
inline constexpr region::Field kept_z = region::rgb;
inline constexpr region::Field rank{202, 4};  ///< Rank of the pixel in its 4 x 4 group.
inline constexpr std::uint32_t shut = 206;    ///< 1 where the door is shut.
inline constexpr std::uint32_t begin =
    rank.address;  ///< Programs of primitives use only bits below.
static_assert(kept_z.width == region::z.width);

}  // namespace pxpl5::isa::door
