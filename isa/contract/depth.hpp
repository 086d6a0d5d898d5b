// The mapping between a projected z, -1..1, and the 24-bit depth of a pixel.
//
//   depth = floor(z_margin + (z_ndc + 1) / 2 * (z_far - 2 z_margin))
//
// Depth 0 is in front, and z_far is the background. The margins keep drawn depths away from both
// values in spite of rounding and slopes. The viewport matrix of the GPs applies this mapping.
#pragma once

#include "isa/contract/region_layout.hpp"

namespace pxpl5::isa {

/// Depth units from the near plane to the far plane.
inline constexpr double depth_span = region::z_far - 2.0 * region::z_margin;

/// Returns the z after the division by w, from -1 (near) to 1 (far), in the middle of the unit.
constexpr double ndc_of_depth(std::uint32_t depth) {
    return (depth + 0.5 - region::z_margin) / depth_span * 2 - 1;
}

}  // namespace pxpl5::isa
