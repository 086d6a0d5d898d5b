// The screen door: where a pixel's memory keeps what a transparent surface needs while it is drawn.
//
// A transparent surface shows in some of each 4 x 4 pixels. In the others its door is shut: their
// depth is put aside and is as near as can be, so that nothing passes the depth test, until the
// door is opened again. rgb is free for that: until the end of the region it holds the background's
// colour alone, which is written again.
#pragma once

#include "isa/contract/region_layout.hpp"

namespace pxpl5::isa::door {

inline constexpr std::uint32_t levels = 16;  ///< Of opacity; a surface with all of them is opaque.
inline constexpr region::Field kept_z = region::rgb;
inline constexpr region::Field rank{202, 4};          ///< Of the pixel in its 4 x 4.
inline constexpr std::uint32_t shut = 206;            ///< 1 where the door is shut.
inline constexpr std::uint32_t begin = rank.address;  ///< Programs of primitives stay below.
static_assert(kept_z.width == region::z.width);

}  // namespace pxpl5::isa::door
