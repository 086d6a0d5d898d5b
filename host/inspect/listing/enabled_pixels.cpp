#include "host/inspect/listing/enabled_pixels.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <tuple>

namespace pxpl5::host::inspect {

namespace hal = renderer::hal;

namespace {

constexpr std::size_t word_bits = 64;

/// Bits of 64 pixels: half a block.
std::uint64_t word_at(const hal::PixelBits& bits, std::size_t word) {
    std::uint64_t value = 0;
    std::memcpy(&value, bits.data() + word * sizeof value, sizeof value);
    return value;
}

bool is_before(hal::Place a, hal::Place b) {
    return std::tie(a.y, a.x) < std::tie(b.y, b.x);
}

}  // namespace

std::size_t enabled_count(const hal::PixelArray& pixels) {
    std::size_t count = 0;
    for (std::size_t word = 0; word < region_pixels / word_bits; ++word) {
        count += static_cast<std::size_t>(std::popcount(word_at(pixels.enable, word)));
    }
    return count;
}

std::optional<RegionPixel> first_enabled(const hal::PixelArray& pixels) {
    // Blocks lie in rows: the first row of blocks that holds an enabled pixel holds the first one.
    std::optional<hal::Place> first;
    constexpr std::size_t words_of_row = hal::blocks_across * hal::block_pixels / word_bits;
    for (std::size_t word = 0; word < region_pixels / word_bits; ++word) {
        if (first && word % words_of_row == 0) {
            break;
        }
        for (std::uint64_t left = word_at(pixels.enable, word); left != 0; left &= left - 1) {
            const hal::Place place =
                hal::place_of(word * word_bits + static_cast<std::size_t>(std::countr_zero(left)));
            first = first && is_before(*first, place) ? first : place;
        }
    }
    return first
               ? std::optional(RegionPixel{static_cast<int>(first->x), static_cast<int>(first->y)})
               : std::nullopt;
}

}  // namespace pxpl5::host::inspect
