// How long the end of a machine waits for its processes.
#pragma once

#include <algorithm>
#include <cstdint>

namespace pxpl5::host {

/// Other computers send logs and traces at the end. Each part of a file gives them more time, but
/// not for ever: a computer that never stops sending must not keep the host from ending.
/// Times in ms, of one clock.
class EndDeadline {
  public:
    static constexpr std::int64_t part_ms = 1000;          ///< From a part to the next.
    static constexpr std::int64_t all_parts_ms = 300'000;  ///< For all parts, after the grace.

    EndDeadline(std::int64_t now_ms, std::int64_t grace_ms)
        : at_ms_(now_ms + grace_ms), latest_ms_(at_ms_ + all_parts_ms) {}

    /// Part of a file came.
    void take_part(std::int64_t now_ms) {
        at_ms_ = std::max(at_ms_, std::min(now_ms + part_ms, latest_ms_));
    }
    /// Begins a step of the end, a signal, that has `patience_ms`.
    void begin_step(std::int64_t now_ms, std::int64_t patience_ms) {
        at_ms_ = now_ms + patience_ms;
        latest_ms_ = std::max(latest_ms_, at_ms_);
    }
    bool is_over(std::int64_t now_ms) const { return now_ms >= at_ms_; }
    /// 0 if it is over.
    std::int64_t left_ms(std::int64_t now_ms) const {
        return std::max<std::int64_t>(0, at_ms_ - now_ms);
    }

  private:
    std::int64_t at_ms_, latest_ms_;
};

}  // namespace pxpl5::host
