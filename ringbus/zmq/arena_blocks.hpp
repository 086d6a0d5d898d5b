// The blocks of an arena that are in use. Offsets and sizes only, no memory.
#pragma once

#include <cstddef>
#include <map>
#include <optional>

namespace pxpl5::bus {

/// Allocates blocks, always the lowest that fits. A recently used block is still in the cache, and
/// the memory above the blocks stays untouched.
class ArenaBlocks {
  public:
    /// Sizes of blocks are multiples of a cache line.
    static constexpr std::size_t grain_bytes = 64;

    /// size_bytes  A multiple of the grain.
    explicit ArenaBlocks(std::size_t size_bytes);

    /// Returns the offset of a block of at least `bytes`, or nothing if none is left.
    std::optional<std::size_t> take(std::size_t bytes);
    /// Releases a block that take(bytes) returned.
    void give_back(std::size_t offset, std::size_t bytes);
    /// Sizes of the free blocks, by offset.
    const std::map<std::size_t, std::size_t>& free() const { return free_; }
    /// Returns the end of the last block in use.
    std::size_t end_in_use() const;

  private:
    std::size_t size_bytes_;
    std::map<std::size_t, std::size_t>
        free_;  ///< Sizes by offset. No two free blocks are adjacent.
};

}  // namespace pxpl5::bus
