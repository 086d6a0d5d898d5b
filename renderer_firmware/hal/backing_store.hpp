// Off-chip memory: 128 blocks of 32 bits for every pixel. A block takes room once it is written.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "isa/executor.hpp"

namespace pxpl5::renderer::hal {

class BackingStore {
  public:
    /// One word per pixel, in the order of pixel_index().
    struct alignas(64) Words {
        std::array<std::uint32_t, isa::region_pixels> at{};
    };

    /// Block `number`, 0..127; null if it was never written and so holds 0.
    const Words* find(std::uint32_t number) const { return blocks_[number].get(); }

    /// Block `number`, 0..127, given room if it has none.
    Words& open(std::uint32_t number);

    /// All blocks hold 0 and take no room.
    void clear() { blocks_ = {}; }

  private:
    std::array<std::unique_ptr<Words>, isa::backing_blocks> blocks_;
};

}  // namespace pxpl5::renderer::hal
