// Counts to times, by a machine's parameters.
#pragma once

#include "host/timing/counts/machine.hpp"
#include "host/timing/counts/times.hpp"

namespace pxpl5::host::timing {

/// Every result is a piece of work in whole nanoseconds, rounded up. Throws RequestError (bad_data)
/// for one of hours.
class Costs {
  public:
    explicit Costs(const Machine& machine);

    Ns host_message() const { return host_message_; }
    Ns gp_message() const { return gp_message_; }
    Ns gp(double cycles) const;
    Ns renderer(std::uint64_t cycles) const;
    Ns link(std::uint64_t words) const;
    /// A packet on a channel; words of its body.
    Ns packet(std::uint64_t words) const;
    /// The first retrace at `time` or after it.
    Ns retrace(Ns time) const;

  private:
    double link_mb_s_, channel_mb_s_, gp_mhz_, renderer_mhz_, refresh_hz_, header_words_;
    Ns host_message_, gp_message_;
};

}  // namespace pxpl5::host::timing
