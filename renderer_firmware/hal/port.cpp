#include "renderer_firmware/hal/port.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>

namespace pxpl5::renderer::hal {

namespace {

/// The frame buffer's core has the rows in its cache. They are requested this many blocks early.
constexpr std::size_t blocks_ahead = 8;

}  // namespace

void Port::aim(std::span<std::uint32_t> rows) {
    assert(rows.empty() || rows.size() == region_pixels);
    rows_ = rows.empty() ? std::span<std::uint32_t>(own_) : rows;
}

std::uint32_t* Port::row_of(std::size_t block) const {
    const Place corner = place_of(block * block_pixels);
    return &rows_[corner.y * region_px + corner.x];
}

void Port::put(std::size_t block, std::span<const std::uint32_t, block_pixels> words) {
    std::uint32_t* row = row_of(block);
    const std::uint32_t* later = row_of(std::min(block + blocks_ahead, block_count - 1));
    for (std::size_t y = 0; y < block_height; ++y) {
        __builtin_prefetch(later + y * region_px, 1);
        // In both orders, four pixels of a tile's row are adjacent.
        for (std::size_t x = 0; x < block_width; x += tile_side) {
            std::memcpy(row + x, &words[pixel_index({x, y})], tile_side * sizeof words[0]);
        }
        row += region_px;
    }
}

}  // namespace pxpl5::renderer::hal
