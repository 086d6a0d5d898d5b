// The nearest and the farthest depth in each cell of a picture.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "host/serve/depths/lean_depths.hpp"

namespace pxpl5::host::serve {

inline constexpr std::uint32_t no_depth = UINT32_MAX;  ///< Farther than every depth.

/// Depths of pixels that show a surface, 24 bits.
struct DepthRange {
    std::uint32_t nearest = no_depth, farthest = 0;

    void add(std::uint32_t depth) {
        nearest = std::min(nearest, depth);
        farthest = std::max(farthest, depth);
    }
};

/// A cell with a pixel that shows a surface.
struct CoveredCell {
    std::uint32_t cell = 0;    ///< Row by row, from 0.
    std::uint32_t corner = 0;  ///< Its upper left corner, row by row.
    DepthRange range;
};

/// Returns the covered cells in order, and sets the bits of `lean.mask`.
///
/// lean    Has its width, height, columns and rows, and a mask of 0.
/// depths  As for lean_depths().
std::vector<CoveredCell> find_covered(LeanDepths& lean, std::span<const std::uint32_t> depths);

}  // namespace pxpl5::host::serve
