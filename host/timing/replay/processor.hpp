// A GP's processor: messages go before other work.
#pragma once

#include <deque>

#include "host/timing/replay/events.hpp"

namespace pxpl5::host::timing {

/// Source: README.md, "GP".
class Processor {
  public:
    explicit Processor(Events& events) : events_(events) {}

    /// Work that goes before work(), behind earlier messages. Returns when it is done.
    Ns message(Ns time);
    /// Work behind all that was asked for before. `done` is called at its end.
    void work(Ns time, Callback<> done);

    const Meter& busy() const { return busy_; }

  private:
    struct Job {
        Ns time = 0;
        Callback<> done;
    };

    void begin_next();
    void end();

    Events& events_;
    Meter busy_;
    std::deque<Job> jobs_;  ///< The first one is under way.
    Ns messages_end_ = 0;   ///< End of the messages.
    Ns job_end_ = 0;        ///< End of the current job, as far as known.
};

}  // namespace pxpl5::host::timing
