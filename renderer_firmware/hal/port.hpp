// The way out to the frame buffer: a word per pixel, turned from storage order into rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer_firmware/hal/pixel_array.hpp"

namespace pxpl5::renderer::hal {

class Port {
  public:
    /// Words go to `rows` from now on, which has room for a region and outlives its use; if it is
    /// empty, to memory of the port's own.
    void aim(std::span<std::uint32_t> rows);

    /// Puts the words of one block, in the order of pixel_index(), in their rows.
    void put(std::size_t block, std::span<const std::uint32_t, block_pixels> words);

    /// What was put last, row by row: index y * 128 + x.
    std::span<const std::uint32_t> rows() const { return rows_; }

  private:
    alignas(64) std::array<std::uint32_t, isa::region_pixels> own_{};
    std::span<std::uint32_t> rows_ = own_;
};

}  // namespace pxpl5::renderer::hal
