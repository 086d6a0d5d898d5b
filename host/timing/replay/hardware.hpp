// The modelled machine's parts that all steps of a run share.
#pragma once

#include <vector>

#include "host/timing/replay/mail.hpp"

namespace pxpl5::host::timing {

/// How long something was busy that does several things at a time.
class UseMeter {
  public:
    void begin(Ns now) {
        if (active_++ == 0) {
            since_ = now;
        }
    }
    void end(Ns now) {
        if (--active_ == 0) {
            total_ += now - since_;
        }
    }
    /// Time up to now in which it did anything.
    Ns at(Ns now) const { return total_ + (active_ > 0 ? now - since_ : 0); }

  private:
    int active_ = 0;
    Ns total_ = 0, since_ = 0;
};

struct Hardware {
    explicit Hardware(const Machine& of)
        : machine(of),
          costs(of),
          places(of),
          ring(of, costs, events, places.count()),
          gps(of.gps, Processor(events)),
          mail(places, costs, events, ring, gps),
          renderers(of.renderers) {}
    Hardware(const Hardware&) = delete;
    Hardware& operator=(const Hardware&) = delete;

    Machine machine;
    Costs costs;
    Places places;
    Events events;
    Ring ring;
    std::vector<Processor> gps;
    Mail mail;
    std::vector<UseMeter> renderers;
};

/// Busy time of every node and channel up to some time.
struct Snapshot {
    Ns time = 0;
    std::vector<Ns> busy;  ///< Host, link, GPs, channels, Renderers, frame buffers' ports.
};
Snapshot snapshot(const Hardware& hardware);

/// One for each Unit but `waiting`. A frame buffer's index is that of its port, over all frame
/// buffers.
std::vector<UnitUse> use_between(const Hardware& hardware, const Snapshot& begin,
                                 const Snapshot& end);

}  // namespace pxpl5::host::timing
