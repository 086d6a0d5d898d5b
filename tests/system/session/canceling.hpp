// A viewer who presses Cancel.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include "host/machine/port.hpp"

namespace pxpl5::test {

/// A viewer who can cancel what a machine's session waits for.
class Canceling {
  public:
    explicit Canceling(host::MachinePort& machine) {
        machine.watch(fd_, [this] {
            eventfd_t count = 0;
            eventfd_read(fd_, &count);
            return true;
        });
    }
    ~Canceling() { close(fd_); }
    Canceling(const Canceling&) = delete;
    Canceling& operator=(const Canceling&) = delete;
    /// The next wait that may be canceled ends at once.
    void press() const { eventfd_write(fd_, 1); }

  private:
    int fd_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
};

}  // namespace pxpl5::test
