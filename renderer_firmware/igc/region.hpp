// One region of one frame: prologue, the segments of all Graphics Processors in order, end of
// region.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "renderer_firmware/igc/igc.hpp"

namespace pxpl5::renderer {

using Words = std::span<const std::uint32_t>;

/// What one Graphics Processor drew of one surface and slab in a region.
struct Segment {
    std::uint32_t surface = 0;  ///< Index into the frame's list of surfaces.
    std::uint32_t slab = 0;
    std::uint32_t gp = 0;
    Words words;
};

/// A segment that was left out, and why.
struct SegmentFault {
    std::uint32_t surface = 0, slab = 0, gp = 0;
    std::string reason;
};

struct RegionResult {
    isa::RunCounts counts;
    std::vector<SegmentFault> faults;
};

/// The programs that a region begins and ends with; checked when they are made.
struct RegionFrame {
    Words prologue, end_of_region;
};

/// Draws a region on `executor`, with a fresh controller. Segments may come in any order: they run
/// by surface, then slab, so that ties of depth do not depend on arrival. Of two segments of one
/// surface and slab the one of the lower GP is run. A segment that is no program is left out; the
/// rest of the region is drawn. The pixels leave through the executor's readout.
/// Throws std::logic_error if prologue or end-of-region program are no programs (a bug of ours).
RegionResult draw_region(isa::Executor& executor, const RegionFrame& frame,
                         std::vector<Segment> segments);

}  // namespace pxpl5::renderer
