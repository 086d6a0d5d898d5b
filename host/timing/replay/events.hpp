// The model's clock: what happens next, and when.
#pragma once

#include <cstdint>
#include <vector>

#include "host/timing/counts/times.hpp"
#include "host/timing/replay/callback.hpp"

namespace pxpl5::host::timing {

/// Events in the order of their times; those of one time in the order in which they were made.
class Events {
  public:
    Ns now() const { return now_; }
    std::uint64_t count() const { return made_; }

    /// `time` is not before now().
    void at(Ns time, Callback<> action);

    /// Lets all happen, and what comes of it. Throws RequestError (bad_data) when that is more than
    /// a replay may take.
    void run();

  private:
    struct Event {
        Ns time = 0;
        std::uint64_t order = 0;
        Callback<> action;
        friend bool operator>(const Event& p, const Event& q) {
            return p.time != q.time ? p.time > q.time : p.order > q.order;
        }
    };

    std::vector<Event> heap_;
    Ns now_ = 0;
    std::uint64_t made_ = 0;
};

/// How long something was busy that does one piece of work after the other without a pause.
class Meter {
  public:
    /// Work that begins now, or behind the work that there is. Returns when it is done.
    Ns add(Ns now, Ns work) {
        end_ = (end_ > now ? end_ : now) + work;
        total_ += work;
        return end_;
    }
    /// Busy time up to now.
    Ns at(Ns now) const { return total_ - (end_ > now ? end_ - now : 0); }
    Ns end() const { return end_; }

  private:
    Ns total_ = 0, end_ = 0;
};

}  // namespace pxpl5::host::timing
