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

}  // namespace pxpl5::host::timing
