// Steps through one region of a recorded frame, instruction by instruction, in both directions.
//
//   0 ......... 4096 ......... 8192 ...... n-1  n      backwards: restore the snapshot at or before
//   snapshot    snapshot       snapshot ------> here   the wanted place, and execute up to it
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "host/inspect/record/region_walk.hpp"
#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::host::inspect {

/// Limits of the snapshots for backward steps.
struct StepLimits {
    std::uint64_t snapshot_every = 4096;  ///< Instructions, at first; doubled when memory is full.
    std::size_t snapshot_bytes = std::size_t{256} << 20;  ///< At least one snapshot is kept.
};

/// A place in a region is the count of instructions that have been executed, 0 .. all of them.
class RegionStepper {
  public:
    /// `plan` outlives it.
    explicit RegionStepper(const renderer::RegionPlan& plan, StepLimits limits = {});
    /// Behind the passes before, if the region's frame is a pass.
    explicit RegionStepper(const RecordedRegion& region, StepLimits limits = {});
    RegionStepper(const RegionStepper&) = delete;
    RegionStepper& operator=(const RegionStepper&) = delete;

    std::uint64_t executed() const { return walk_.counts().instructions; }
    bool done() const { return walk_.done(); }
    const RegionWalk& walk() const { return walk_; }
    const renderer::fast::Fast& executor() const { return executor_; }

    /// Executes one instruction. Not when done().
    void step();
    /// Goes to where `executed` instructions have been executed, or to the end if there are fewer.
    void seek(std::uint64_t executed);
    void seek_end();

    /// Goes to the newest snapshot at or before `executed`, from which on step() leads there.
    void seek_snapshot(std::uint64_t executed);
    std::size_t snapshots() const { return snapshots_.size(); }

  private:
    struct Snapshot {
        RegionWalk::State walk;
        renderer::fast::Fast::State pixels;
    };
    void keep_snapshot();
    void thin_out();

    StepLimits limits_;
    std::uint64_t every_;
    renderer::fast::Fast executor_;
    RegionWalk walk_;
    std::map<std::uint64_t, Snapshot> snapshots_;  ///< By instructions executed; 0 is always there.
    std::size_t bytes_ = 0;                        ///< Size of all snapshots.
};

}  // namespace pxpl5::host::inspect
