// Several descriptors as one, for programs that wait for one.
#pragma once

#include <sys/epoll.h>
#include <unistd.h>

#include <cerrno>
#include <initializer_list>
#include <system_error>

namespace pxpl5::host {

/// Readable while one of its descriptors is.
class PollSet {
  public:
    /// Throws std::system_error.
    PollSet(std::initializer_list<int> descriptors) : fd_(epoll_create1(EPOLL_CLOEXEC)) {
        check(fd_ >= 0);
        for (const int descriptor : descriptors) {
            add(descriptor);
        }
    }
    ~PollSet() { close(fd_); }
    PollSet(const PollSet&) = delete;
    PollSet& operator=(const PollSet&) = delete;

    int fd() const { return fd_; }
    void add(int descriptor) {
        epoll_event event{};
        event.events = EPOLLIN;
        check(epoll_ctl(fd_, EPOLL_CTL_ADD, descriptor, &event) == 0);
    }
    void remove(int descriptor) { epoll_ctl(fd_, EPOLL_CTL_DEL, descriptor, nullptr); }

  private:
    static void check(bool good) {
        if (!good) {
            throw std::system_error(errno, std::generic_category(), "cannot wait for descriptors");
        }
    }
    int fd_;
};

}  // namespace pxpl5::host
