// Pauses of long work, in which the caller looks at signals and viewers.
#pragma once

#include <cstddef>
#include <functional>

namespace pxpl5::host {

/// Called between pieces of work. What it throws ends the work. May be empty.
using Pause = std::function<void()>;

/// Steps of a loop between two pauses. A step takes about 0.1 us, for example for a triangle.
inline constexpr std::size_t steps_per_pause = std::size_t{1} << 18;

/// Pauses before each step whose number `interval` divides, except before the first.
inline void pause_at(std::size_t step, const Pause& pause, std::size_t interval = steps_per_pause) {
    if (step % interval == 0 && step > 0 && pause) {
        pause();
    }
}

}  // namespace pxpl5::host
