#include "renderer_firmware/hal/pixel_array.hpp"

#include <cassert>
#include <cstring>

namespace pxpl5::renderer::hal {

void PixelArray::clear() {
    std::memset(blocks.data(), 0, sizeof blocks);
    enable.fill(0);
    carry.fill(0);
    occupied = {};
}

std::uint64_t field(const PixelArray& pixels, std::size_t index, std::uint32_t a, std::uint32_t n) {
    assert(index < region_pixels && n >= 1 && n <= 64 && a + n <= isa::memory_bits);
    const Block& block = pixels.blocks[index / block_pixels];
    std::uint64_t value = 0;
    std::uint32_t taken = 0;
    while (taken < n) {
        const std::uint32_t bit = a + taken;
        const std::uint64_t word = block.columns[bit / 32][index % block_pixels];
        value |= (word >> bit % 32) << taken;
        taken += 32 - bit % 32;
    }
    return n == 64 ? value : value & ((std::uint64_t{1} << n) - 1);
}

}  // namespace pxpl5::renderer::hal
