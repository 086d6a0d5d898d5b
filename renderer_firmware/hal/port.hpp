// The output to the frame buffer: converts one word per pixel from storage order to rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "renderer_firmware/hal/pixel_array.hpp"

namespace pxpl5::renderer::hal {

class Port {
  public:
    /// From now on words go to `rows`, which has room for a region and must outlive its use. If
    /// `rows` is empty, words go to memory of the port.
    void aim(std::span<std::uint32_t> rows);

    /// Writes the words of one block, in the order of pixel_index(), to their rows.
    void put(std::size_t block, std::span<const std::uint32_t, block_pixels> words);

    /// Returns the newest words, row by row: index y * 128 + x.
    std::span<const std::uint32_t> rows() const { return rows_; }

  private:
    /// The place of the upper left pixel of a block.
    std::uint32_t* row_of(std::size_t block) const;

    alignas(64) std::array<std::uint32_t, region_pixels> own_{};
    std::span<std::uint32_t> rows_ = own_;
};

}  // namespace pxpl5::renderer::hal
