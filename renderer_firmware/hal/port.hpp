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

    /// Takes the words in the order of pixel_index().
    void take(const Words& stored);

    /// What was taken last, row by row: index y * 128 + x.
    std::span<const std::uint32_t> rows() const { return rows_; }

  private:
    alignas(64) Words rows_{};
};

}  // namespace pxpl5::renderer::hal
