// The rate of a network, from the times of answers.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

namespace pxpl5::host {

/// The rate of a network, from the times that answers with and without bytes take.
///
/// A busy computer may answer late, but no answer comes early. So the shortest time of each kind is
/// used: if the delay came from one late empty answer, the computed rate would be too high.
class NetworkRate {
  public:
    /// Adds the time of a question with an answer without bytes.
    void add_empty(std::int64_t ns) { empty_ns_ = std::min(empty_ns_, ns); }

    /// Adds the time of a question with an answer of `bytes` bytes. Another size starts again.
    void add_full(std::uint32_t bytes, std::int64_t ns) {
        full_ns_ = bytes == bytes_ ? std::min(full_ns_, ns) : ns;
        bytes_ = bytes;
    }

    /// 10^6 bytes per second. Requires an answer of each kind.
    double mb_s() const {
        assert(empty_ns_ != none && bytes_ > 0);
        const auto ns = std::max<std::int64_t>(full_ns_ - empty_ns_, 1);
        return 1e3 * bytes_ / static_cast<double>(ns);
    }

  private:
    static constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();

    std::int64_t empty_ns_ = none;
    std::int64_t full_ns_ = 0;
    std::uint32_t bytes_ = 0;
};

/// Asks a computer for an answer of `bytes` bytes. Returns the time until it comes, nanoseconds, or
/// nothing if it comes too late.
using AskForBytes = std::function<std::optional<std::int64_t>(std::uint32_t bytes)>;

/// Measures the rate of a network, in 10^6 bytes per second: first with empty answers, then with
/// small ones, and with large ones only if the small ones were fast. On a slow network, a large
/// answer would delay the heartbeats of its computer. Returns nothing if the empty answers, the
/// first small one or the first large one do not arrive in time.
std::optional<double> measured_mb_s(const AskForBytes& ask);

/// Sizes of the answers with bytes.
inline constexpr std::uint32_t small_answer_bytes = 1U << 15U, large_answer_bytes = 1U << 19U;

}  // namespace pxpl5::host
