// A place in a recorded run, and ways to move it: instruction, primitive, part, region, frame, to
// the next breakpoint; each forward and backward.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "host/inspect/record/recorded_run.hpp"
#include "host/inspect/step/breakpoint.hpp"
#include "host/inspect/step/region_stepper.hpp"

namespace pxpl5::host::inspect {

/// Behind `executed` instructions of a region of a frame. Places are in the order in which frames,
/// then regions, are numbered; Renderers in fact draw theirs at the same time.
struct RunPlace {
    std::uint32_t frame = 0, region = 0;
    std::uint64_t executed = 0;
    auto operator<=>(const RunPlace&) const = default;
};

enum class Direction : std::uint8_t { forward, backward };

class Stepper {
  public:
    /// Stands at the begin of the first region of `frame`. `run` outlives it.
    /// Throws RequestError (usage) if the frame is not there, (bad_data) if none of its regions is.
    Stepper(const RecordedRun& run, std::uint32_t frame, StepLimits limits = {});

    RunPlace place() const { return {frame_.number, region().place.number, here_->executed()}; }
    const RecordedFrame& frame() const { return frame_; }
    const RecordedRegion& region() const { return *region_; }
    const RegionStepper& here() const { return *here_; }
    /// The primitives of the region.
    std::span<const Primitive> primitives() const { return primitives_; }

    /// One instruction on; from a region's end to the begin of the next one. False at the run's
    /// end.
    bool step();
    /// One instruction back; from a region's begin to the end of the one before. False at the
    /// run's begin.
    bool back();

    /// Goes to the next place, or the one before, at which a breakpoint holds; to the end or the
    /// begin of the run if there is none. Returns the index of the breakpoint.
    std::optional<std::size_t> run_to(std::span<const Break> breaks, Direction direction);

    /// Moves to the start of the next region. Backward, moves to the start of this region, or from
    /// there to the previous region. Returns false without a move if no such region exists.
    bool to_region(Direction direction);
    bool to_frame(Direction direction);  ///< See to_region().

    /// Throws RequestError (usage) if frame or region is not there. Stops at the region's end.
    void go_to(RunPlace place);

  private:
    bool enter_neighbor(Direction direction);
    void enter(RecordedFrame frame, std::uint32_t region);
    void enter(std::uint32_t region);
    std::optional<RecordedFrame> neighbor_frame(Direction direction) const;
    std::optional<std::size_t> run_here(Watch& watch);
    std::optional<std::size_t> run_back_here(Watch& watch, std::uint64_t end, bool include_end);

    const RecordedRun& run_;
    StepLimits limits_;
    RecordedFrame frame_;
    const RecordedRegion* region_ = nullptr;  ///< Element of frame_.
    std::vector<Primitive> primitives_;       ///< All primitives of *region_.
    std::unique_ptr<RegionStepper> here_;
};

}  // namespace pxpl5::host::inspect
