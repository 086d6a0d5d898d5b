// A region: the pixels that one Renderer's array covers.
#pragma once

#include <cstddef>

namespace pxpl5::isa {

namespace region {
inline constexpr int size_px = 128;  ///< A region has 128 x 128 pixels.
}  // namespace region

inline constexpr std::size_t region_pixels =
    static_cast<std::size_t>(region::size_px) * static_cast<std::size_t>(region::size_px);

}  // namespace pxpl5::isa
