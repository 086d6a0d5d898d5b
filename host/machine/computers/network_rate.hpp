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
/// Answers are late by chance, as computers do other things, but never early. So the shortest time
/// of each kind counts. A single late answer without bytes would make a slow network seem fast.
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

/// Measures the rate of a network with few questions, in 10^6 bytes per second. The first answers
/// have no bytes, and the next ones few: on a slow network, a large answer would hold up the beats
/// of its computer. Large answers are asked for where the small ones were fast. Returns nothing if
/// no answer with bytes, or no large one, has come.
std::optional<double> measured_mb_s(const AskForBytes& ask);

/// Sizes of the answers with bytes.
inline constexpr std::uint32_t small_answer_bytes = 1U << 15U, large_answer_bytes = 1U << 19U;

}  // namespace pxpl5::host
