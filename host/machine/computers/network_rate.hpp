#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace pxpl5::host {

/// The rate of a network, from the times that answers with and without bytes take.
///
/// Answers are late by chance, as computers do other things, but never early. So the shortest time
/// of each kind counts. A single late answer without bytes would make a slow network seem fast.
class NetworkRate {
  public:
    /// Adds the time of a question with an answer without bytes.
    void add_empty(std::int64_t ns) { empty_ns_ = std::min(empty_ns_, ns); }

    /// Adds the time of a question with an answer of `bytes` bytes, the same size each time.
    void add_full(std::uint32_t bytes, std::int64_t ns) {
        full_ns_ = bytes == bytes_ ? std::min(full_ns_, ns) : ns;
        bytes_ = bytes;
    }

    /// 10^6 bytes per second; needs an answer of each kind.
    double mb_s() const {
        const auto ns = std::max<std::int64_t>(full_ns_ - empty_ns_, 1);
        return 1e3 * bytes_ / static_cast<double>(ns);
    }

  private:
    std::int64_t empty_ns_ = std::numeric_limits<std::int64_t>::max();
    std::int64_t full_ns_ = 0;
    std::uint32_t bytes_ = 0;
};

}  // namespace pxpl5::host
