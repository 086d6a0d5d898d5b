// Pauses of long work, in which the caller looks at signals and viewers.
#pragma once

#include <cstdint>
#include <functional>

namespace pxpl5::host {

/// Called between pieces of work. What it throws ends the work. May be empty.
using Pause = std::function<void()>;

/// Counts the steps of loops, and pauses every few hundredths of a second.
class Pauses {
  public:
    /// pause  Must outlive this object.
    explicit Pauses(const Pause& pause) : pause_(pause) {}
    void step() {
        if (++steps_ % steps_per_pause == 0 && pause_) {
            pause_();
        }
    }

  private:
    /// A step takes about 0.1 us.
    static constexpr std::uint64_t steps_per_pause = std::uint64_t{1} << 18;
    const Pause& pause_;
    std::uint64_t steps_ = 0;
};

}  // namespace pxpl5::host
