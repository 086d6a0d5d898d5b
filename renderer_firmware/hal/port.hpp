// The way out to the frame buffer: a word per pixel, turned from storage order into rows.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "isa/executor.hpp"

namespace pxpl5::renderer::hal {

class Port {
  public:
    using Words = std::array<std::uint32_t, isa::region_pixels>;

    /// Where the words are put, in the order of pixel_index().
    Words& stored() { return stored_; }

    /// Turns what is stored into rows.
    void turn();

    /// What was turned last, row by row: index y * 128 + x.
    std::span<const std::uint32_t> rows() const { return rows_; }

  private:
    alignas(64) Words stored_{};
    alignas(64) Words rows_{};
};

}  // namespace pxpl5::renderer::hal
