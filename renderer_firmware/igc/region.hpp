// One region of one frame: prologue, the segments of all Graphics Processors in order, the depths
// if they are wanted, end of region. A transparent surface's segments run behind its door.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
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
    std::uint32_t first_word = 0;  ///< Where `words` begin in the GP's stream for the region.
};

/// A segment that was left out, and why.
struct SegmentFault {
    std::uint32_t surface = 0, slab = 0, gp = 0;
    std::string reason;
};

/// What runs before and behind a transparent surface's segments.
struct Door {
    std::uint32_t surface = 0;
    Words shut, open;
};

/// The Renderer's own programs of the regions of a frame. They have passed check_own().
struct RegionFrame {
    Words prologue, end_of_region;
    std::vector<Door> doors{};  ///< Of the transparent surfaces.
    Words depths{};             ///< Empty unless depths are wanted.
    bool holds_sums = false;    ///< The backing store does: no segment may touch it.
};

/// Throws std::logic_error if one of the programs is none (a bug of ours). Once a frame: a check
/// takes longer than all else of planning an empty region.
void check_own(const RegionFrame& frame);

/// What a region runs, in order: prologue, by surface its segments, behind its door if it has one,
/// depths, end-of-region program.
struct RegionPlan {
    /// In the order in which they run; of one surface the three in the middle.
    enum class Kind : std::uint8_t {
        prologue,
        shut_door,
        segment,
        open_door,
        depths,
        end_of_region
    };
    struct Part {
        Kind kind = Kind::segment;
        Segment segment;  ///< Of a door words and surface count; of the others the words.
    };
    std::vector<Part> parts;           ///< All of them valid programs.
    std::vector<SegmentFault> faults;  ///< Segments that are left out.
};

/// Segments may come in any order: they run by surface, then slab, so that ties of depth do not
/// depend on arrival. Of two segments of one surface and slab the one of the lower GP is run. A
/// segment that is no program is left out.
RegionPlan plan_region(const RegionFrame& frame, std::vector<Segment> segments);

/// What one part of a region executed.
struct PartCounts {
    RegionPlan::Kind kind = RegionPlan::Kind::segment;
    std::uint32_t surface = 0;  ///< Of a segment and of doors.
    std::uint32_t slab = 0;     ///< Of a segment, as are the next two.
    std::uint32_t primitives = 0, words = 0;
    isa::InstructionCounts executed;
};

struct RegionResult {
    isa::RunCounts counts;
    std::vector<SegmentFault> faults;
    std::vector<PartCounts> parts;  ///< In order; empty unless they are counted.
};

enum class Counting : std::uint8_t { whole_region, each_part };

/// Called before a part runs: what is read out then is that part's.
using PartWatcher = std::function<void(RegionPlan::Kind)>;

/// Draws a region as planned on `executor`, with a fresh controller. A segment that cannot run to
/// its end is left where it stopped; the rest of the region is drawn. The pixels leave through the
/// executor's readout, after the depths if these are wanted.
/// counting  Counting each part costs time where a part's flow depends on pixels.
RegionResult draw_region(isa::Executor& executor, const RegionFrame& frame,
                         std::vector<Segment> segments, const PartWatcher& before_part = {},
                         Counting counting = Counting::whole_region);

}  // namespace pxpl5::renderer
