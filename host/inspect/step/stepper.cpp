#include "host/inspect/step/stepper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "host/base/error.hpp"

namespace pxpl5::host::inspect {

namespace {

std::string reasons(const RecordedFrame& frame) {
    return frame.missing.empty() ? "it has none" : frame.missing.front();
}

}  // namespace

Stepper::Stepper(const RecordedRun& run, std::uint32_t frame, StepLimits limits)
    : run_(run), limits_(limits) {
    RecordedFrame first = run.frame(frame);
    if (first.regions.empty()) {
        throw RequestError(ExitCode::bad_data,
                           fmt::format("frame {}: none of its regions can be executed: {}", frame,
                                       reasons(first)));
    }
    const std::uint32_t region = first.regions.begin()->first;
    enter(std::move(first), region);
}

void Stepper::enter(RecordedFrame frame, std::uint32_t region) {
    here_.reset();  // Points into the old frame.
    frame_ = std::move(frame);
    enter(region);
}

void Stepper::enter(std::uint32_t region) {
    region_ = &frame_.regions.at(region);
    primitives_ = primitives_of(frame_, *region_);
    here_ = std::make_unique<RegionStepper>(*region_, limits_);
}

/// The nearest frame in that direction of which a region can be executed.
std::optional<RecordedFrame> Stepper::neighbor_frame(Direction direction) const {
    std::vector<std::uint32_t> numbers = run_.frames();
    if (direction == Direction::backward) {
        std::ranges::reverse(numbers);
    }
    auto at = std::ranges::find(numbers, frame_.number);
    while (at != numbers.end() && ++at != numbers.end()) {
        if (RecordedFrame frame = run_.frame(*at); !frame.regions.empty()) {
            return frame;
        }
    }
    return std::nullopt;
}

/// Enters the region that follows, or goes before, at its begin.
bool Stepper::enter_neighbor(Direction direction) {
    const auto at = frame_.regions.find(region().place.number);
    if (direction == Direction::forward && std::next(at) != frame_.regions.end()) {
        enter(std::next(at)->first);
        return true;
    }
    if (direction == Direction::backward && at != frame_.regions.begin()) {
        enter(std::prev(at)->first);
        return true;
    }
    std::optional<RecordedFrame> frame = neighbor_frame(direction);
    if (!frame) {
        return false;
    }
    const std::uint32_t number = direction == Direction::forward ? frame->regions.begin()->first
                                                                 : frame->regions.rbegin()->first;
    enter(std::move(*frame), number);
    return true;
}

bool Stepper::step() {
    if (here_->done()) {
        return enter_neighbor(Direction::forward);
    }
    here_->step();
    return true;
}

bool Stepper::back() {
    if (here_->executed() > 0) {
        here_->seek(here_->executed() - 1);
        return true;
    }
    if (!enter_neighbor(Direction::backward)) {
        return false;
    }
    here_->seek_end();
    return true;
}

/// On to the first place of this region behind the present one.
std::optional<std::size_t> Stepper::run_here(Watch& watch) {
    while (!here_->done()) {
        watch.before(*here_);
        here_->step();
        if (const auto found = watch.after(*here_)) {
            return found;
        }
    }
    return std::nullopt;
}

/// Back to the last place of this region at which a breakpoint holds, among 0 .. end-1, or 0 .. end
/// if told. Stretches between snapshots are executed, the last one first.
std::optional<std::size_t> Stepper::run_back_here(Watch& watch, std::uint64_t end,
                                                  bool include_end) {
    if (end == 0 && !include_end) {
        return std::nullopt;
    }
    for (std::uint64_t last = include_end ? end : end - 1;;) {
        // Places last .. first+1 are reached by steps from first; place 0 by none.
        here_->seek_snapshot(last == 0 ? 0 : last - 1);
        const std::uint64_t first = here_->executed();
        std::optional<std::pair<std::uint64_t, std::size_t>> newest;
        if (first == 0) {
            if (const auto found = watch.after(*here_)) {
                newest = {0, *found};
            }
        }
        while (here_->executed() < last) {
            watch.before(*here_);
            here_->step();
            if (const auto found = watch.after(*here_)) {
                newest = {here_->executed(), *found};
            }
        }
        if (newest) {
            here_->seek(newest->first);
            return newest->second;
        }
        if (first == 0) {
            return std::nullopt;
        }
        last = first;
    }
}

std::optional<std::size_t> Stepper::run_to(std::span<const Break> breaks, Direction direction) {
    const bool forward = direction == Direction::forward;
    bool entered = false;  // From a neighbor: the first, or last, place of this region counts.
    do {
        Watch watch(breaks, frame_, *region_, primitives_);
        if (watch.possible() && forward) {
            std::optional<std::size_t> found;
            found = entered ? watch.after(*here_) : std::nullopt;
            found = found ? found : run_here(watch);
            if (found) {
                return found;
            }
        } else if (watch.possible()) {
            if (entered) {
                here_->seek_end();
            }
            if (const auto found = run_back_here(watch, here_->executed(), entered)) {
                return found;
            }
        }
        entered = true;
    } while (enter_neighbor(direction));
    forward ? here_->seek_end() : here_->seek(0);
    return std::nullopt;
}

bool Stepper::to_region(Direction direction) {
    if (direction == Direction::backward && here_->executed() > 0) {
        here_->seek(0);
        return true;
    }
    return enter_neighbor(direction);
}

bool Stepper::to_frame(Direction direction) {
    const std::uint32_t first = frame_.regions.begin()->first;
    if (direction == Direction::backward && place() > RunPlace{frame_.number, first, 0}) {
        enter(first);
        return true;
    }
    std::optional<RecordedFrame> frame = neighbor_frame(direction);
    if (!frame) {
        return false;
    }
    const std::uint32_t number = frame->regions.begin()->first;
    enter(std::move(*frame), number);
    return true;
}

void Stepper::go_to(RunPlace place) {
    if (place.frame != frame_.number) {
        RecordedFrame frame = run_.frame(place.frame);
        if (!frame.regions.contains(place.region)) {
            throw RequestError(ExitCode::usage,
                               fmt::format("region {} of frame {} cannot be "
                                           "executed: {}",
                                           place.region, place.frame, reasons(frame)));
        }
        enter(std::move(frame), place.region);
    } else if (place.region != region().place.number) {
        if (!frame_.regions.contains(place.region)) {
            throw RequestError(ExitCode::usage,
                               fmt::format("frame {} has no region {} that can be executed: {}",
                                           place.frame, place.region, reasons(frame_)));
        }
        enter(place.region);
    }
    here_->seek(place.executed);
}

}  // namespace pxpl5::host::inspect
