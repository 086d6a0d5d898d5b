#include "host/timing/simulate.hpp"

#include "host/timing/replay/replay.hpp"

namespace pxpl5::host::timing {

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

}  // namespace pxpl5::host::timing
