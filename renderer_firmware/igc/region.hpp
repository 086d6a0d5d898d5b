// Draws one region of one frame: prologue, segments of all Graphics Processors in order, depths on
// request, end-of-region program. Door programs enclose the segments of a transparent surface.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "generated/vocabulary.hpp"
#include "renderer_firmware/igc/igc.hpp"

namespace pxpl5::renderer {

using Words = std::span<const std::uint32_t>;

/// The program of one Graphics Processor for one surface and slab in a region.
struct Segment {
    std::uint32_t surface = 0;  ///< Index into the frame's list of surfaces.
    std::uint32_t slab = 0;
    std::uint32_t gp = 0;
    Words words;
    std::uint32_t first_word = 0;  ///< Offset of `words` in the GP's stream for the region.
};

/// Whether a segment draws anything in its region.
bool draws(std::span<const Segment> segments);

/// A skipped segment and the reason.
struct SegmentFault {
    std::uint32_t surface = 0, slab = 0, gp = 0;
    std::string reason;
};

/// The programs before and after the segments of a transparent surface.
struct Door {
    std::uint32_t surface = 0;
    Words shut, open;
};

/// The Renderer's own programs for the regions of a frame. They have passed check_own().
struct RegionFrame {
    Words prologue, end_of_region;
    std::vector<Door> doors{};  ///< Doors of the transparent surfaces.
    Words depths{};             ///< Empty unless depths are requested.
    bool holds_sums = false;    ///< The backing store holds sums. Segments must not use it.
};

/// Throws std::logic_error if a program is invalid (a bug of ours). Call it once per frame: the
/// check takes longer than all other planning of an empty region.
void check_own(const RegionFrame& frame);

/// The parts of a region in order: prologue, the segments by surface and between the programs of
/// the door, depths, end-of-region program.
struct RegionPlan {
    struct Part {
        PartKind kind = PartKind::segment;
        Segment segment;  ///< Doors use words and surface; segments use all; other kinds use words.
    };
    std::vector<Part> parts;           ///< All of them are valid programs.
    std::vector<SegmentFault> faults;  ///< Skipped segments.
};

/// Orders segments by surface, then by slab, so that ties of depth do not depend on arrival. Of two
/// segments for one surface and slab, the segment of the lower GP runs. Invalid programs are
/// skipped.
RegionPlan plan_region(const RegionFrame& frame, std::vector<Segment> segments);

/// The executed instructions of one part of a region.
struct PartCounts {
    PartKind kind = PartKind::segment;
    std::uint32_t surface = 0;  ///< For segments and doors.
    std::uint32_t slab = 0;     ///< For segments, like the next two.
    std::uint32_t primitives = 0, words = 0;
    isa::InstructionCounts executed;
};

struct RegionResult {
    isa::RunCounts counts;
    std::vector<SegmentFault> faults;
    std::vector<PartCounts> parts;  ///< In order; empty unless parts are counted.
};

enum class Counting : std::uint8_t { whole_region, each_part };

/// Called before each part. The next readout belongs to this part.
using PartWatcher = std::function<void(PartKind)>;

/// Draws a planned region on `executor` with a new controller. If a segment stops with an error,
/// its effects so far remain, and the rest of the region is drawn. The executor's readout receives
/// the depths, if requested, and then the pixels.
/// counting  Counting each part takes extra time if the flow of a part depends on pixels.
RegionResult draw_region(isa::Executor& executor, const RegionFrame& frame,
                         std::vector<Segment> segments, const PartWatcher& before_part = {},
                         Counting counting = Counting::whole_region);

}  // namespace pxpl5::renderer
