// What a depth means: between the projection's z, in -1..1, and the 24 bits in a pixel.
//
//   depth = floor(z_margin + (z_ndc + 1) / 2 * (z_far - 2 z_margin))
//
// 0 is in front. The margins keep whatever rounding and slopes do to a drawn depth clear of 0 and
// of z_far, which is the background's.
#pragma once

#include "isa/contract/region_layout.hpp"

namespace pxpl5::isa {

/// Depth units from the near plane to the far plane.
inline constexpr double depth_span = region::z_far - 2.0 * region::z_margin;

/// z after the division by w, OpenGL's -1 (near) .. 1 (far), of the middle of a depth's unit.
constexpr double ndc_of_depth(std::uint32_t depth) {
    return (depth + 0.5 - region::z_margin) / depth_span * 2 - 1;
}

/// The depth, with its fraction, of a z after the division by w.
constexpr double depth_of_ndc(double z_ndc) {
    return region::z_margin + (z_ndc + 1) / 2 * depth_span;
}

}  // namespace pxpl5::isa
