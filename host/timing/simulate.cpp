#include "host/timing/simulate.hpp"

#include <algorithm>
#include <array>

#include "host/timing/replay.hpp"

namespace pxpl5::host::timing {

std::string_view name_of(Unit unit) {
    static constexpr std::array<std::string_view, 7> names = {
        "host", "host link", "GP", "ring", "Renderer", "frame buffer", "waiting"};
    return names.at(static_cast<std::size_t>(unit));
}

const UnitUse& busiest_of(const std::vector<UnitUse>& use) {
    return *std::ranges::max_element(use, {}, &UnitUse::busiest);
}

Unit limit_of(const std::vector<UnitUse>& use) {
    const UnitUse& most = busiest_of(use);
    return most.busiest < least_limit_share ? Unit::waiting : most.unit;
}

RunTime simulate(const Machine& machine, const RunWork& run) {
    std::vector<StepRef> steps;
    for (const StepWork& work : run.steps) {
        steps.push_back(std::visit([](const auto& step) { return StepRef(&step); }, work));
    }
    Replay replay(machine, steps);
    replay.run();
    RunTime result;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const Replay::Step& step = replay.steps()[i];
        StepTime time{i, step.begin.time, step.end.time, {}, {}};
        time.use = use_between(replay.hardware(), step.begin, step.end);
        time.limit = limit_of(time.use);
        result.steps.push_back(std::move(time));
    }
    result.ring = replay.hardware().ring.counts();
    result.events = replay.hardware().events.count();
    return result;
}

namespace {
// Warm-up: the pipeline is full after as many frames as may be under way; then the assignment by
// costs has its frame before. Window: whole patterns of 1, 2, 3, 4, 6 and 12 frames.
constexpr std::size_t settling_frames = 4, window_frames = 12;
}  // namespace

Rate frame_rate(const Machine& machine, const FrameWork& frame) {
    const auto in_flight = static_cast<std::size_t>(machine.frames_in_flight);
    const std::size_t begin = settling_frames + in_flight, end = begin + window_frames;
    // Those behind keep the machine as busy as before.
    const std::vector<StepRef> steps(end + 1 + in_flight, StepRef(&frame));
    Replay replay(machine, steps);
    replay.run();
    const Replay::Step &first = replay.steps()[begin], &last = replay.steps()[end];
    Rate rate;
    constexpr double ns_per_s = 1e9;
    rate.frames_per_s = static_cast<double>(window_frames) * ns_per_s /
                        static_cast<double>(last.complete.time - first.complete.time);
    rate.latency = last.known - last.begin.time;
    rate.use = use_between(replay.hardware(), first.complete, last.complete);
    rate.limit = limit_of(rate.use);
    return rate;
}

}  // namespace pxpl5::host::timing
