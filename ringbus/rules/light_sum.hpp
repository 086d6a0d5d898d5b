// The light that the pixel processors can add up.
#pragma once

namespace pxpl5::bus {

/// Most that the ambient light and the intensities of all lights of a frame may add up to; 1 is
/// white. The Renderer's fields for light end below 4.
inline constexpr float max_light_sum = 3.9F;

}  // namespace pxpl5::bus
