// A picture without its ground.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pxpl5::host {

/// The picture of what stands before the ground, from the same picture over black and over white.
/// Only ground differs between both, by its share of the samples of a pixel: 255 for ground alone.
///
/// over_black, over_white  Pixels with red in the low byte, as many in both.
/// samples                 Per pixel.
///
/// Returns pixels whose alpha is the share of the samples that show a surface, and whose color is
/// the mean of these samples alone: not multiplied by alpha. Pixels of ground alone are 0.
std::vector<std::uint32_t> without_ground(std::span<const std::uint32_t> over_black,
                                          std::span<const std::uint32_t> over_white, int samples);

}  // namespace pxpl5::host
