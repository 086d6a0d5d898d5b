// Blocks signals for a while.
#pragma once

#include <pthread.h>
#include <csignal>

namespace pxpl5::host {

/// Blocks all signals in this thread. Threads started during its lifetime inherit the blocked
/// signals, so that signals reach the main thread.
class SignalsBlocked {
  public:
    SignalsBlocked() {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_BLOCK, &all, &before_);
    }
    ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsBlocked(const SignalsBlocked&) = delete;
    SignalsBlocked& operator=(const SignalsBlocked&) = delete;

  private:
    sigset_t before_{};
};

}  // namespace pxpl5::host
