// The history of one pixel while its region was drawn: the region's programs, executed again on
// that pixel by the reference executor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/inspect/record/region_walk.hpp"

namespace pxpl5::host::inspect {

/// The fields of a pixel that triangles write (isa/contract/region_layout.hpp), and its enable bit.
struct PixelState {
    bool enabled = false;
    std::uint32_t surface = 0;  ///< 0 is the background, else 1 + index in the frame's list.
    std::uint32_t z = 0;        ///< Depth, 0 in front.
    std::array<int, 3> normal{};
    std::uint32_t rgb = 0;  ///< Red in the low byte.
    friend bool operator==(const PixelState&, const PixelState&) = default;
};

/// An instruction that stored into the pixel's memory.
struct PixelWrite {
    Address address;
    std::uint64_t at = 0;  ///< Instructions of the region that are executed before it.
    std::string text;      ///< The instruction as assembly.
    PixelState before, after;
};

/// A primitive whose shape covers the pixel: it came as far as its depth test, or stored.
struct PixelVisit {
    std::size_t primitive = 0;       ///< Index into the region's primitives.
    std::optional<std::uint32_t> z;  ///< Its own depth at the pixel, as tested.
    PixelState before, after;        ///< At its SETENABS, and behind its last instruction.
    std::vector<PixelWrite> writes;  ///< Empty if it lost the depth test.
    std::uint32_t surface = 0;       ///< Its own: index in the frame's list.
};

struct PixelHistory {
    int x = 0, y = 0;  ///< Pixel of the whole picture.
    RegionPlace place;
    std::vector<Primitive> primitives;  ///< All of the region, in the order in which they ran.
    std::vector<PixelWrite> prologue;
    std::vector<PixelVisit> visits;            ///< In order.
    std::vector<PixelWrite> doors;             ///< Stores of stipple masks.
    std::vector<std::uint32_t> shut_surfaces;  ///< Whose doors these are: indices, ascending.
    std::vector<PixelWrite> end_of_region;
    PixelState drawn;                   ///< Before the end-of-region program.
    std::uint32_t color = 0;            ///< Word read out; red in the low byte.
    std::optional<std::uint32_t> sent;  ///< The color in the recorded frame, if there is one.
    std::uint64_t instructions = 0;     ///< Count of the region.

    /// The visit that the pixel shows: the last that stored. Null for the background.
    const PixelVisit* shown() const;
    /// Whether a door keeps the visit's surface out of this pixel: it lost to no other primitive.
    bool is_shut_out(const PixelVisit& visit) const;
    int x_in_region() const { return x - place.x0_px; }
    int y_in_region() const { return y - place.y0_px; }
};

/// Executes the region again. Conditions of the controller (ANYENAB) depend on all pixels of the
/// region: their outcomes are taken from a run of the whole region on the fast executor.
///
/// x, y     A pixel of the region, in the whole picture.
PixelHistory history_of(const RecordedFrame& frame, const RecordedRegion& region, int x, int y);

}  // namespace pxpl5::host::inspect
