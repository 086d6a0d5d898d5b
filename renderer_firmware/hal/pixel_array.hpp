// The 128 x 128 pixels of a Renderer: 208 bits of memory, an enable bit and a carry bit each.
//
// Memory is stored as bit columns: word k of a pixel contains bits 32k .. 32k+31. Pixels are stored
// by block (16 x 8 pixels), with all columns of a block together. A block is stored by tile (4 x 4
// pixels), row by row:
//
//     region: 8 x 16 blocks      block: 4 x 2 tiles       tile: 16 pixels, 64 bytes a column
//     +---+---+-- ...  --+       +---+---+---+---+        +--+--+--+--+
//     | 0 | 1 |          |       | 0 | 1 | 2 | 3 |        | 0| 1| 2| 3|
//     +---+---+-- ...  --+       +---+---+---+---+        | 4| 5| 6| 7|
//     | 8 | 9 |          |       | 4 | 5 | 6 | 7 |        | .. 15     |
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "isa/executor.hpp"

namespace pxpl5::renderer::hal {

inline constexpr std::size_t column_count = 7;  ///< Number of 32-bit words per pixel.
inline constexpr std::size_t tile_side = 4;
inline constexpr std::size_t tile_pixels = tile_side * tile_side;
inline constexpr std::size_t block_width = 16;
inline constexpr std::size_t block_height = 8;
inline constexpr std::size_t block_pixels = block_width * block_height;
inline constexpr std::size_t blocks_across = 8;
inline constexpr std::size_t block_count = region_pixels / block_pixels;
static_assert(column_count * 32 >= isa::memory_bits);

/// The position of a pixel in the region, 0..127 each.
struct Place {
    std::size_t x, y;
    friend bool operator==(const Place&, const Place&) = default;
};

/// Returns the storage index of pixel `p`: block * block_pixels + index in the block.
constexpr std::size_t pixel_index(Place p) {
    const std::size_t block = p.y / block_height * blocks_across + p.x / block_width;
    const std::size_t tile = (p.y / tile_side % 2) * 4 + p.x / tile_side % 4;
    return block * block_pixels + tile * tile_pixels + p.y % tile_side * tile_side +
           p.x % tile_side;
}

/// Returns the pixel of a storage index.
constexpr Place place_of(std::size_t index) {
    const std::size_t block = index / block_pixels, tile = index / tile_pixels % 8;
    const std::size_t in_tile = index % tile_pixels;
    return {block % blocks_across * block_width + tile % 4 * tile_side + in_tile % tile_side,
            block / blocks_across * block_height + tile / 4 * tile_side + in_tile / tile_side};
}

/// The memory of 16 x 8 pixels.
struct alignas(64) Block {
    std::array<std::array<std::uint32_t, block_pixels>, column_count> columns;
};

/// One bit per pixel, bit i of the region in byte i / 8.
using PixelBits = std::array<std::uint8_t, region_pixels / 8>;

struct PixelArray {
    std::array<Block, block_count> blocks{};
    alignas(64) PixelBits enable{};
    alignas(64) PixelBits carry{};
    /// Bit b % 64 of word b / 64 is set exactly if block b has an enabled pixel.
    std::array<std::uint64_t, block_count / 64> occupied{};

    bool is_occupied(std::size_t block) const {
        return (occupied[block / 64] >> block % 64 & 1) != 0;
    }
    void set_occupied(std::size_t block, bool any) {
        const std::uint64_t bit = std::uint64_t{1} << block % 64;
        occupied[block / 64] = any ? occupied[block / 64] | bit : occupied[block / 64] & ~bit;
    }
    /// Computes the bit of a block in `occupied` from its enables.
    void note_occupied(std::size_t block) {
        std::uint64_t bits[block_pixels / 64];
        std::memcpy(bits, &enable[block * block_pixels / 8], sizeof bits);
        set_occupied(block, (bits[0] | bits[1]) != 0);
    }
    /// Sets all bits to 0.
    void clear();
    bool any_enabled() const { return (occupied[0] | occupied[1]) != 0; }
};

/// Returns bit `index` of `bits`.
inline bool bit_of(const PixelBits& bits, std::size_t index) {
    return (bits[index / 8] >> index % 8 & 1) != 0;
}

/// Returns field m[a : a+n) of the pixel at `index`, zero-extended; n is 1..64, a + n <= 208.
std::uint64_t field(const PixelArray& pixels, std::size_t index, std::uint32_t a, std::uint32_t n);

}  // namespace pxpl5::renderer::hal
