#include "host/timing/replay/events.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <functional>

#include "host/base/error.hpp"

namespace pxpl5::host::timing {

namespace {
constexpr std::uint64_t max_events = 2'000'000'000;
}

void Events::at(Ns time, Callback<> action) {
    assert(time >= now_);
    heap_.push_back({time, made_++, action});
    std::ranges::push_heap(heap_, std::greater{});
}

void Events::run() {
    while (!heap_.empty()) {
        if (made_ > max_events) {
            throw RequestError(ExitCode::bad_data,
                               fmt::format("the replay has {} events at {} ns; at most {} may be",
                                           made_, now_, max_events));
        }
        std::ranges::pop_heap(heap_, std::greater{});
        Event event = heap_.back();
        heap_.pop_back();
        now_ = event.time;
        event.action();
    }
}

}  // namespace pxpl5::host::timing
