#include "host/serve/director/pace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace pxpl5::host::serve {

namespace {

constexpr std::array<double, 3> scales = {1, 0.75, 0.5};
constexpr int enough_quick = 8;  // Frames: a third of a second.
constexpr double room = 0.75;    // Share of goal_ms that the next size may take.

}  // namespace

double Pace::scale() const {
    return scales[static_cast<std::size_t>(step_)];
}

void Pace::drawn(double ms, bool is_whole) {
    if (ms > goal_ms) {
        step_ += step_ + 1 < static_cast<int>(scales.size()) ? 1 : 0;
        quick_ = 0;
        return;
    }
    if (step_ == 0 || !is_whole) {
        return;
    }
    const double growth = scales[static_cast<std::size_t>(step_) - 1] / scale();
    quick_ = ms * growth * growth < room * goal_ms ? quick_ + 1 : 0;
    if (quick_ == enough_quick) {
        --step_;
        quick_ = 0;
    }
}

}  // namespace pxpl5::host::serve
