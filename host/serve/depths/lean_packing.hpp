// Lean depths as the bytes that go to a viewer.
#pragma once

#include <string>

#include "host/serve/depths/lean_depths.hpp"

namespace pxpl5::host::serve {

/// A raw deflate stream (RFC 1951) of
///
/// 1. the mask, each row combined with the row above by exclusive or,
/// 2. the low bytes of the differences of all corners, then their high bytes,
/// 3. a bit per cell, the first cell lowest: 1 is a seam,
/// 4. of all seams, the low bytes of `near_pixels`, then the high bytes,
/// 5. for each corner of `near`, then of `far`: the low bytes of the differences of all seams, then
///    the high bytes.
///
/// The prediction of a corner is left + up - upper left of its neighbors, limited to 1 to max_lean.
/// Neighbors outside of the picture are 0. A corner of 0 has the difference 0, and the corners
/// after it are predicted as if it had its predicted depth. The prediction of a depth of a seam is
/// the corner. A difference d has 12 bits, and is stored as 2 d, or as -2 d - 1 if d is negative.
///
/// Throws std::runtime_error with the reason of zlib.
std::string packed(const LeanDepths& lean);

/// The depths of pictures of the same size: for each, the number of its bytes, as 32 bits with the
/// lowest byte first, and what packed() returns.
///
/// depths  pictures * width * height words, as for lean_depths(); the first picture first.
///
/// Throws as packed() and lean_depths() do.
std::string packed_stack(int width, int height, int pictures,
                         std::span<const std::uint32_t> depths);

}  // namespace pxpl5::host::serve
