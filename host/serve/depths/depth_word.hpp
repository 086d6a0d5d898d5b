// The parts of a word of FrameDone's depths.
#pragma once

#include <cstdint>

#include "isa/contract/region_layout.hpp"

namespace pxpl5::host::serve {

/// Whether the pixel shows a surface, and not the background.
constexpr bool shows_surface(std::uint32_t word) {
    return (word & ((1U << isa::region::surface.width) - 1)) != 0;
}

/// The depth, 24 bits: smaller is nearer.
constexpr std::uint32_t depth_of(std::uint32_t word) {
    return word >> isa::region::surface.width;
}

}  // namespace pxpl5::host::serve
