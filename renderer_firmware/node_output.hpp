// The message that takes finished regions to one frame buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::renderer {

/// The regions of a message.
struct OutputRegions {
    std::size_t all = 0;
    std::size_t with_pixels = 0;  ///< All, or 0 in a pass that is not the last of its picture.
    std::size_t with_depths = 0;
    bool reads_depths = false;
};

/// A RegionPixels message that regions are read out into, one after the other.
class RegionOutput {
  public:
    /// memory  Where the body lies; null: on the heap.
    RegionOutput(const OutputRegions& regions, flatbuffers::Allocator* memory);

    /// The words of the next region's pixels, or of its depths; empty if the message has none.
    std::span<std::uint32_t> next_pixels() const { return next_of(pixels_, tiles_.size()); }
    std::span<std::uint32_t> next_depths() const { return next_of(depths_, with_depths_); }
    /// Ends the next region.
    void add(const bus::schema::RegionTile& tile) {
        tiles_.push_back(tile);
        with_depths_ += tile.has_depths() ? 1 : 0;
    }

    /// The message of Renderer `renderer`. Call it once.
    bus::Payload finish(std::uint32_t frame, std::uint32_t renderer, double moved_mm);

  private:
    /// One word per pixel of all regions, in the body of the unfinished message.
    struct Words {
        flatbuffers::Offset<flatbuffers::Vector<std::uint32_t>> offset;
        std::span<std::uint32_t> words;
    };
    Words room_for(std::size_t regions);
    static std::span<std::uint32_t> next_of(const Words& words, std::size_t regions);

    flatbuffers::FlatBufferBuilder body_;
    Words pixels_, depths_;
    std::vector<bus::schema::RegionTile> tiles_;  ///< Tiles of the finished regions.
    std::size_t with_depths_ = 0;                 ///< Number of tiles with depths.
};

}  // namespace pxpl5::renderer
