// Off-chip memory: 128 blocks of 32 bits for every pixel. Memory is allocated at the first write.
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
        std::array<std::uint32_t, region_pixels> at{};
    };

    /// Returns block `number`, 0..127, or null if it was never written and therefore is 0.
    const Words* find(std::uint32_t number) const { return blocks_[number].get(); }

    /// Returns block `number`, 0..127. Allocates the block if necessary.
    Words& open(std::uint32_t number);

    /// Sets all blocks to 0 and frees their memory.
    void clear() { blocks_ = {}; }

  private:
    std::array<std::unique_ptr<Words>, isa::backing_blocks> blocks_;
};

}  // namespace pxpl5::renderer::hal
