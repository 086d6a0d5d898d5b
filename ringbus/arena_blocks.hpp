// Which parts of an arena are in use: offsets and sizes only, no memory.
#pragma once

#include <cstddef>
#include <map>
#include <optional>

namespace pxpl5::bus {

/// Gives out blocks, always the lowest that fits: what was in use a moment ago is still in the
/// cache, and the memory above is never touched.
class ArenaBlocks {
  public:
    /// Blocks are multiples of a cache line.
    static constexpr std::size_t grain_bytes = 64;

    /// size_bytes  A multiple of the grain.
    explicit ArenaBlocks(std::size_t size_bytes);

    /// Returns the offset of a block of at least `bytes`, or nothing if none is left.
    std::optional<std::size_t> take(std::size_t bytes);
    /// Ends a block that take(bytes) gave.
    void give_back(std::size_t offset, std::size_t bytes);
    /// Where the last block in use ends.
    std::size_t end_in_use() const;

  private:
    std::size_t size_bytes_;
    std::map<std::size_t, std::size_t> free_;  ///< Sizes by offset; no two of them touch.
};

}  // namespace pxpl5::bus
