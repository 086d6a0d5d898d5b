#include "host/timing/replay/replay.hpp"

#include <fmt/format.h>

#include <cassert>

#include "host/base/error.hpp"
#include "host/timing/counts/check_work.hpp"

namespace pxpl5::host::timing {

Replay::Replay(const Machine& machine, std::span<const StepRef> steps)
    : hardware_(machine),
      load_(hardware_),
      build_(hardware_),
      frames_(hardware_),
      refs_(steps),
      times_(steps.size()) {}

void Replay::run() {
    start_steps();
    hardware_.events.run();
    assert(next_ == refs_.size());
    assert(under_way_ == 0);
}

bool Replay::may_start() const {
    if (next_ == refs_.size() || under_way_ == 0) {
        return next_ < refs_.size();
    }
    const auto is_frame = [&](std::size_t step) {
        return std::holds_alternative<const FrameWork*>(refs_[step]);
    };
    return is_frame(next_) && is_frame(next_ - 1) &&
           static_cast<double>(under_way_) < hardware_.machine.frames_in_flight;
}

void Replay::start_steps() {
    while (may_start()) {
        start(next_++);
    }
}

void Replay::start(std::size_t step) {
    ++under_way_;
    times_[step].begin = snapshot(hardware_);
    try {
        std::visit([&](const auto* work) { start(step, *work); }, refs_[step]);
    } catch (const RequestError& error) {
        throw RequestError(error.code, fmt::format("step {}: {}", step, error.what()));
    }
}

void Replay::start(std::size_t step, const VolumeWork& volume) {
    check_volume(volume);
    volume_ = &volume;
    load_.start(volume, [this, step] { known(step); });
}

void Replay::start(std::size_t step, const BuildWork& build) {
    check_build(build, volume_);
    build_.start(build, *volume_, [this, step] { known(step); });
}

void Replay::start(std::size_t step, const FrameWork& frame) {
    if (frame_ != &frame) {
        plan_ = std::make_shared<const FramePlan>(hardware_.machine, hardware_.costs, frame);
        frame_ = &frame;
    }
    FrameRun run;
    run.plan = plan_;
    const Assignment assignment = hardware_.machine.assignment;
    if (is_handed_out(assignment)) {
        run.order = order_of(assignment, plan_->regions(), costs_drawn_);
    } else {
        run.assignment = static_assignment(hardware_.machine, frame);
    }
    run.complete = [this, step] { complete(step); };
    run.shown = [this, step] { end(step); };
    run.known = [this, step] { known(step); };
    frames_.draw(std::move(run));
}

void Replay::complete(std::size_t step) {
    times_[step].complete = snapshot(hardware_);
    costs_drawn_ = std::get<const FrameWork*>(refs_[step])->region_cycles();
}

void Replay::end(std::size_t step) {
    times_[step].end = snapshot(hardware_);
}

void Replay::known(std::size_t step) {
    if (!std::holds_alternative<const FrameWork*>(refs_[step])) {
        end(step);
        times_[step].complete = times_[step].end;
    }
    times_[step].known = hardware_.events.now();
    --under_way_;
    start_steps();
}

}  // namespace pxpl5::host::timing
