#include "host/timing/replay/costs.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "host/base/error.hpp"

namespace pxpl5::host::timing {

namespace {

constexpr double ns_per_us = 1e3, ns_per_s = 1e9;
constexpr double bytes_per_word = 4;
constexpr double max_piece_ns = 1e13;  // So that no sum of pieces runs over.

Ns whole(double ns) {
    if (!(ns <= max_piece_ns)) {
        throw RequestError(
            ExitCode::bad_data,
            fmt::format("a piece of work of {:.3g} ns; at most {:.3g} may be", ns, max_piece_ns));
    }
    return static_cast<Ns>(std::ceil(ns));
}

// 1 MB/s is 1 byte a microsecond, 1 MHz 1 cycle a microsecond.
Ns at_rate(double amount, double per_us) {
    return whole(amount * ns_per_us / per_us);
}

}  // namespace

Costs::Costs(const Machine& machine)
    : link_mb_s_(machine.host_link_mb_s),
      channel_mb_s_(machine.ring_channel_mb_s),
      gp_mhz_(machine.gp_clock_mhz),
      renderer_mhz_(machine.renderer_clock_mhz),
      refresh_hz_(machine.frame_buffer_refresh_hz),
      header_words_(machine.ring_header_words),
      host_message_(whole(machine.host_message_us * ns_per_us)),
      gp_message_(whole(machine.gp_message_us * ns_per_us)) {
    assert(link_mb_s_ > 0);
    assert(channel_mb_s_ > 0);
    assert(gp_mhz_ > 0);
    assert(renderer_mhz_ > 0);
    assert(refresh_hz_ > 0);
}

Ns Costs::gp(double cycles) const {
    return at_rate(cycles, gp_mhz_);
}

Ns Costs::renderer(std::uint64_t cycles) const {
    return at_rate(static_cast<double>(cycles), renderer_mhz_);
}

Ns Costs::link(std::uint64_t words) const {
    return at_rate(static_cast<double>(words) * bytes_per_word, link_mb_s_);
}

Ns Costs::packet(std::uint64_t words) const {
    return at_rate((static_cast<double>(words) + header_words_) * bytes_per_word, channel_mb_s_);
}

Ns Costs::retrace(Ns time) const {
    const auto number = static_cast<double>(time) * refresh_hz_ / ns_per_s;
    auto count = static_cast<Ns>(number);
    const auto nth = [this](Ns n) {
        return static_cast<Ns>(std::ceil(static_cast<double>(n) * ns_per_s / refresh_hz_));
    };
    while (nth(count) < time) {
        ++count;
    }
    return nth(count);
}

}  // namespace pxpl5::host::timing
