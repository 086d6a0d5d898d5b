#include "renderer_firmware/hal/port.hpp"

#include <cassert>
#include <cstring>

namespace pxpl5::renderer::hal {

void Port::aim(std::span<std::uint32_t> rows) {
    assert(rows.empty() || rows.size() == region_pixels);
    rows_ = rows.empty() ? std::span<std::uint32_t>(own_) : rows;
}

void Port::put(std::size_t block, std::span<const std::uint32_t, block_pixels> words) {
    const Place corner = place_of(block * block_pixels);
    std::uint32_t* row = &rows_[corner.y * region_px + corner.x];
    for (std::size_t y = 0; y < block_height; ++y) {
        // In both orders, four pixels of a tile's row are adjacent.
        for (std::size_t x = 0; x < block_width; x += tile_side) {
            std::memcpy(row + x, &words[pixel_index({x, y})], tile_side * sizeof words[0]);
        }
        row += region_px;
    }
}

}  // namespace pxpl5::renderer::hal
