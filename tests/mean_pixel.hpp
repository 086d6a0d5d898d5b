// Computes the expected pixels of a picture of several passes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pxpl5::test {

/// A pixel's mean over pictures of one size: each of the three lower bytes, halves up.
inline std::uint32_t mean_pixel(const std::vector<std::vector<std::uint32_t>>& pictures,
                                std::size_t pixel) {
    const auto count = static_cast<std::uint32_t>(pictures.size());
    std::uint32_t word = 0;
    for (std::uint32_t shift = 0; shift < 24; shift += 8) {
        std::uint32_t sum = 0;
        for (const std::vector<std::uint32_t>& picture : pictures) {
            sum += picture.at(pixel) >> shift & 255;
        }
        word |= (2 * sum + count) / (2 * count) << shift;
    }
    return word;
}

}  // namespace pxpl5::test
