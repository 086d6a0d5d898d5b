#include "host/timing/picture.hpp"

#include <algorithm>
#include <utility>

#include "host/timing/replay/replay.hpp"

namespace pxpl5::host::timing {

namespace {

// Warm-up: the pipeline is full after as many frames as may be under way; then the assignment by
// costs has its frame before. Window: whole patterns of 1, 2, 3, 4, 6 and 12 pictures.
constexpr std::size_t settling_frames = 4, window_pictures = 12;

/// Whether the frame is the pass behind these, or the first of a picture if there are none.
bool follows(const FrameWork& frame, const std::vector<const FrameWork*>& passes) {
    return frame.sample == passes.size() &&
           (passes.empty() || (frame.samples == passes.front()->samples &&
                               frame.frame == passes.front()->frame + frame.sample));
}

}  // namespace

std::vector<Picture> pictures_of(const RunWork& run) {
    std::vector<Picture> pictures;
    Picture next;
    for (std::size_t step = 0; step < run.steps.size(); ++step) {
        const auto* frame = std::get_if<FrameWork>(&run.steps[step]);
        if (frame == nullptr || !follows(*frame, next.passes)) {
            next.passes.clear();  // The picture before is not whole.
        }
        if (frame != nullptr && follows(*frame, next.passes)) {
            next.step = next.passes.empty() ? step : next.step;
            next.passes.push_back(frame);
            if (next.passes.size() == frame->samples) {
                pictures.push_back(std::exchange(next, {}));
            }
        }
    }
    return pictures;
}

std::optional<Picture> picture_at(const RunWork& run, std::size_t step) {
    const std::vector<Picture> pictures = pictures_of(run);
    const auto found = std::ranges::find_if(pictures, [&](const Picture& one) {
        return one.step <= step && step < one.step + one.passes.size();
    });
    return found == pictures.end() ? std::nullopt : std::optional(*found);
}

Rate picture_rate(const Machine& machine, const Picture& picture) {
    const auto in_flight = static_cast<std::size_t>(machine.frames_in_flight);
    const std::size_t passes = picture.passes.size();
    const std::size_t settled = (settling_frames + in_flight + passes - 1) / passes;
    const std::size_t before = settled * passes + passes - 1;  // A last pass, as `last` is.
    const std::size_t last = before + window_pictures * passes;
    // Those behind keep the machine as busy as before.
    std::vector<StepRef> steps;
    for (std::size_t i = 0; i < last + 1 + in_flight; ++i) {
        steps.emplace_back(picture.passes[i % passes]);
    }
    Replay replay(machine, steps);
    replay.run();
    const std::vector<Replay::Step>& times = replay.steps();
    const Snapshot &first = times[before].complete, &end = times[last].complete;
    Rate rate;
    constexpr double ns_per_s = 1e9;
    rate.frames_per_s = static_cast<double>(window_pictures) * ns_per_s /
                        static_cast<double>(end.time - first.time);
    rate.latency = times[last].known - times[last + 1 - passes].begin.time;
    rate.drawn = end.time - times[last + 1 - passes].begin.time;
    rate.use = use_between(replay.hardware(), first, end);
    rate.limit = limit_of(rate.use);
    return rate;
}

Rate frame_rate(const Machine& machine, const FrameWork& frame) {
    return picture_rate(machine, {0, {&frame}});
}

}  // namespace pxpl5::host::timing
