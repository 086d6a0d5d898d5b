// A run's steps on a machine, one behind the other; frames overlap.
#pragma once

#include <memory>
#include <span>
#include <unordered_map>
#include <variant>
#include <vector>

#include "host/timing/replay/build_model.hpp"
#include "host/timing/replay/frame_model.hpp"
#include "host/timing/replay/hardware.hpp"
#include "host/timing/replay/load_model.hpp"

namespace pxpl5::host::timing {

/// A step that the caller owns.
using StepRef = std::variant<const VolumeWork*, const BuildWork*, const FrameWork*>;

class Replay {
  public:
    Replay(const Machine& machine, std::span<const StepRef> steps);
    Replay(const Replay&) = delete;
    Replay& operator=(const Replay&) = delete;

    /// Once. Throws RequestError (bad_data), with the step's index.
    void run();

    /// A step's times. Of what is no frame the last three are the same.
    struct Step {
        Snapshot begin;
        Snapshot complete;  ///< The frame buffer has the last pixel.
        Snapshot end;       ///< The frame is shown.
        Ns known = 0;       ///< Time at which the host knows.
    };
    const std::vector<Step>& steps() const { return times_; }
    const Hardware& hardware() const { return hardware_; }

  private:
    bool may_start() const;
    void start_steps();
    void start(std::size_t step);
    void start(std::size_t step, const VolumeWork& volume);
    void start(std::size_t step, const BuildWork& build);
    void start(std::size_t step, const FrameWork& frame);
    void complete(std::size_t step);
    void end(std::size_t step);
    void known(std::size_t step);

    Hardware hardware_;
    LoadModel load_;
    BuildModel build_;
    FrameModel frames_;
    std::span<const StepRef> refs_;
    std::vector<Step> times_;
    std::size_t next_ = 0, under_way_ = 0;
    const VolumeWork* volume_ = nullptr;      ///< Loaded last.
    const FrameWork* frame_ = nullptr;        ///< Drawn last.
    std::shared_ptr<const FramePlan> plan_;   ///< The plan of frame_.
    std::vector<std::uint64_t> costs_drawn_;  ///< Cycles of each region of the newest drawn.
};

}  // namespace pxpl5::host::timing
