#include "ringbus/stage_clock.hpp"

#include <algorithm>
#include <cassert>

namespace pxpl5::bus {

StageClock::StageClock() : stages_{{stage::wait}}, since_(Clock::now()) {
    stages_.reserve(max_stages);
}

void StageClock::enter(std::string_view name) {
    if (name == current()) {
        return;
    }
    count_time();
    current_ = index_of(name);
    ++stages_[current_].count;
}

void StageClock::move(std::string_view from, std::string_view to, std::uint64_t ns) {
    count_time();
    Stage& source = stages_[index_of(from)];
    // Two clocks of one stretch may differ by a reading.
    const std::uint64_t moved = std::min(ns, source.ns);
    source.ns -= moved;
    Stage& target = stages_[index_of(to)];
    target.ns += moved;
    ++target.count;
}

const std::vector<StageClock::Stage>& StageClock::stages() {
    count_time();
    return stages_;
}

void StageClock::count_time() {
    const Clock::time_point now = Clock::now();
    stages_[current_].ns += static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(now - since_).count());
    since_ = now;
}

std::size_t StageClock::index_of(std::string_view name) {
    const auto found = std::ranges::find(stages_, name, &Stage::name);
    const auto index = static_cast<std::size_t>(found - stages_.begin());
    if (found == stages_.end()) {
        assert(stages_.size() < max_stages);
        stages_.push_back({name});
    }
    return index;
}

}  // namespace pxpl5::bus
