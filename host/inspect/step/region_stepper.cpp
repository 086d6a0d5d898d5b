#include "host/inspect/step/region_stepper.hpp"

#include <cassert>
#include <iterator>

#include "host/inspect/replay/executors.hpp"

namespace pxpl5::host::inspect {

RegionStepper::RegionStepper(const renderer::RegionPlan& plan, StepLimits limits)
    : limits_(limits), every_(limits.snapshot_every), walk_(plan, executor_) {
    assert(limits.snapshot_every > 0);
    keep_snapshot();
}

RegionStepper::RegionStepper(const RecordedRegion& region, StepLimits limits)
    : limits_(limits), every_(limits.snapshot_every), walk_(region.plan, executor_) {
    assert(limits.snapshot_every > 0);
    prepare(region, executor_);
    keep_snapshot();
}

void RegionStepper::step() {
    walk_.step();
    if (executed() % every_ == 0) {
        keep_snapshot();
    }
}

void RegionStepper::seek(std::uint64_t executed) {
    const auto after = snapshots_.upper_bound(executed);
    const std::uint64_t nearest = std::prev(after)->first;
    if (executed < this->executed() || nearest > this->executed()) {
        seek_snapshot(executed);
    }
    while (!done() && this->executed() < executed) {
        step();
    }
}

void RegionStepper::seek_end() {
    seek_snapshot(std::prev(snapshots_.end())->first);
    while (!done()) {
        step();
    }
}

void RegionStepper::seek_snapshot(std::uint64_t executed) {
    const Snapshot& snapshot = std::prev(snapshots_.upper_bound(executed))->second;
    executor_.restore(snapshot.pixels);
    walk_.restore(snapshot.walk);
}

void RegionStepper::keep_snapshot() {
    if (snapshots_.contains(executed())) {
        return;
    }
    Snapshot snapshot{walk_.save(), executor_.save()};
    bytes_ += snapshot.pixels.bytes();
    snapshots_.emplace(executed(), std::move(snapshot));
    while (bytes_ > limits_.snapshot_bytes && snapshots_.size() > 1) {
        thin_out();
    }
}

/// Drops every second snapshot: what is left is twice as far apart.
void RegionStepper::thin_out() {
    every_ *= 2;
    for (auto it = snapshots_.begin(); it != snapshots_.end();) {
        if (it->first % every_ == 0) {
            ++it;
        } else {
            bytes_ -= it->second.pixels.bytes();
            it = snapshots_.erase(it);
        }
    }
}

}  // namespace pxpl5::host::inspect
