// Signals that come between two Supervisors, while the machine is started again.
#pragma once

#include <deque>
#include <memory>

namespace pxpl5::host {

/// While it exists, SIGINT, SIGTERM and SIGHUP do not end this process: without a Supervisor they
/// would, and nothing would be saved or removed. One exists at a time, in the Supervisors' thread;
/// all other threads block these signals.
class KeptSignals {
  public:
    /// Throws MachineError (69).
    KeptSignals();
    ~KeptSignals();
    KeptSignals(const KeptSignals&) = delete;
    KeptSignals& operator=(const KeptSignals&) = delete;

    /// The object that exists; nullptr if there is none.
    static KeptSignals* current();

    /// Called by a Supervisor that ends, with the signals that it leaves. The Supervisor has
    /// counted all signals so far.
    void hand_over(const std::deque<int>& left);
    /// Signals for the Supervisor that begins: those handed over, and those that came since then.
    std::deque<int> take();

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::host
