// The sums of an antialiased picture in the backing store.
//
// An antialiased picture is the mean of 4 or 16 frames, the passes. The Renderer that draws a
// region stores three sums of 8-bit colors per pixel, in a slot of one or two blocks: the sums of 4
// passes need 30 bits, and those of 16 passes need 36 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "generated/vocabulary.hpp"
#include "isa/executor.hpp"

namespace pxpl5::isa {

/// Returns the blocks per region; 0 for a picture of one frame.
constexpr std::uint32_t sum_blocks(std::uint32_t samples) {
    return samples <= 1 ? 0 : samples <= few_samples ? 1 : 2;
}

/// Returns the number of regions for which one Renderer has blocks.
constexpr std::size_t max_summed_regions(std::uint32_t samples) {
    return samples <= 1 ? std::numeric_limits<std::size_t>::max()
                        : backing_blocks / sum_blocks(samples);
}

}  // namespace pxpl5::isa
