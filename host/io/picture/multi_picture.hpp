// Two JPEG files of a stereo pair as one multi-picture file (.mpo).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace pxpl5::host::io {

/// One JPEG file for each eye.
struct JpegPair {
    std::span<const std::uint8_t> left, right;
};

/// Both files, one behind the other. Each gets an APP2 segment "MPF" behind its APP0 and APP1
/// segments; that of the left eye has the index: sizes and places of both. Readers of JPEG show the
/// left eye.
///
/// baseline_mm  Distance between the eyes, 0..1e6.
/// Source  CIPA DC-007-2009, "Multi-Picture Format", type Multi-Frame Disparity.
/// Throws PictureError if a file is no JPEG file, or if both together exceed 4 GiB.
std::vector<std::uint8_t> multi_picture(const JpegPair& pair, double baseline_mm);

}  // namespace pxpl5::host::io
