// Where the backing store keeps the sums of a picture that is drawn several times.
//
// A picture may be the mean of 4 or 16 frames, its passes. Each region has a slot at the Renderer
// that draws it, of as many blocks as three sums of 8-bit colours take: of 4 passes 30 bits, of 16
// passes 36.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "isa/executor.hpp"

namespace pxpl5::isa {

/// Frames that a picture may be the mean of, besides 1.
inline constexpr std::uint32_t few_samples = 4, many_samples = 16;

/// Of one region; 0 of a picture of one frame, which is not summed.
constexpr std::uint32_t sum_blocks(std::uint32_t samples) {
    return samples <= 1 ? 0 : samples <= few_samples ? 1 : 2;
}

/// Regions of a picture that one Renderer has room for.
constexpr std::size_t max_summed_regions(std::uint32_t samples) {
    return samples <= 1 ? std::numeric_limits<std::size_t>::max()
                        : backing_blocks / sum_blocks(samples);
}

}  // namespace pxpl5::isa
