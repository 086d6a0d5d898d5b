// Pictures in smaller sizes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/base/command_line.hpp"

namespace pxpl5::host::serve {

/// The size of a moving picture, at least 64 pixels a side unless `full` has less.
///
/// full   Size of the picture at rest.
/// scale  Above 0, at most 1.
Size moving_size(const Size& full, double scale);

/// Pictures of one size, from top to bottom, in a smaller size. A new pixel is the mean of the area
/// that it covers, for each channel of 8 bits alone; halves are rounded up. Each picture is reduced
/// alone, so that the edges of two pictures do not mix.
///
/// rgba      pictures * from.height * from.width.
/// from, to  Of one picture; `to` is not larger in any direction.
std::vector<std::uint32_t> reduced_pixels(std::span<const std::uint32_t> rgba, const Size& from,
                                          const Size& to, int pictures);

/// Likewise for depths and surface numbers: a new pixel has the word of the pixel at its middle. A
/// mean would be a depth between two surfaces, where there is nothing.
std::vector<std::uint32_t> reduced_depths(std::span<const std::uint32_t> depths, const Size& from,
                                          const Size& to, int pictures);

}  // namespace pxpl5::host::serve
