// Executes one region's programs again and counts their effects on each pixel.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/inspect/record/region_walk.hpp"

namespace pxpl5::host::inspect {

/// No primitive's number.
inline constexpr std::uint32_t no_primitive = 0xFFFF'FFFF;

/// One number per pixel of a region, row by row: index y * 128 + x.
using PerPixel = std::vector<std::uint32_t>;

struct RegionCensus {
    isa::RunCounts counts;  ///< Counts of the whole run.
    PerPixel active;        ///< Instructions that began while the pixel was enabled.
    PerPixel covered;       ///< Primitives that had it enabled when they first used its memory.
    PerPixel written;       ///< Primitives that wrote its memory.
    PerPixel visible;       ///< Number of the last primitive that wrote its memory.
    // Fields as the end-of-region program finds them:
    PerPixel surface, z;
    PerPixel normal;  ///< x, y and z, ten bits each.
    PerPixel rgb;     ///< Read out at the end; red in the low byte.
};

/// Executes the region, instruction by instruction.
/// primitives  Those of the region.
RegionCensus take_census(const RecordedRegion& region, std::span<const Primitive> primitives);

/// Counts, for each pixel, how many bit maps had its bit set. Bits of equal weight of all counts
/// are kept together, so that adding a map costs two operations a word.
class BitMapCounter {
  public:
    static constexpr std::size_t words = region_pixels / 64;
    using Map = std::array<std::uint64_t, words>;

    /// Adds words first .. first+count-1 of `map`.
    void add(const Map& map, std::size_t first, std::size_t count);
    /// Returns the count of bit `index`.
    std::uint32_t count(std::size_t index) const;

  private:
    static constexpr std::size_t planes = 32;
    std::vector<Map> planes_ = std::vector<Map>(planes);
};

}  // namespace pxpl5::host::inspect
