#include "host/machine/sessions/session_end.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "host/base/error.hpp"
#include "host/machine/processes/supervisor.hpp"
#include "host/machine/sessions/run_state.hpp"

namespace pxpl5::host {

namespace {

/// A process that no other one can be taken for.
class ProcessHandle {
  public:
    explicit ProcessHandle(pid_t pid) : fd_(static_cast<int>(syscall(SYS_pidfd_open, pid, 0))) {}
    ~ProcessHandle() {
        if (fd_ >= 0) {
            close(fd_);
        }
    }
    ProcessHandle(const ProcessHandle&) = delete;
    ProcessHandle& operator=(const ProcessHandle&) = delete;

    bool is_open() const { return fd_ >= 0; }
    bool send(int signal) const {
        return syscall(SYS_pidfd_send_signal, fd_, signal, nullptr, 0) == 0;
    }
    /// False if it has not ended in time.
    bool wait(int limit_ms) const {
        pollfd ended{fd_, POLLIN, 0};
        const std::int64_t end_ms = now_ms() + limit_ms;
        int ready = -1;
        do {
            const std::int64_t left_ms = std::max<std::int64_t>(end_ms - now_ms(), 0);
            ready = poll(&ended, 1, static_cast<int>(left_ms));
        } while (ready < 0 && errno == EINTR);
        return ready > 0;
    }

  private:
    int fd_;
};

/// The line that ends a session on another computer.
std::string line_for(const RunningSession& session) {
    return session.job.empty() ? fmt::format("ssh {} kill -TERM {}", session.computer, session.pid)
                               : fmt::format("scancel {}", session.job);
}

}  // namespace

int end_session(const RunningSession& session, int limit_ms) {
    if (!session.is_here) {
        throw RequestError(
            ExitCode::unavailable,
            fmt::format("sessions: {} runs on computer {}, not on {}. Run '{}'", session.name,
                        session.computer, computer_name(), line_for(session)));
    }
    const auto pid = static_cast<pid_t>(session.pid);
    const ProcessHandle process(pid);
    const int reason = errno;
    // After the handle: the process that has the number now is the one that the handle means.
    if (start_of(pid) != session.process_start) {
        return 0;  // It has ended in the meantime.
    }
    const std::int64_t begin_ms = now_ms();
    if (!process.is_open() || !process.send(SIGTERM)) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("sessions: process {} of {} cannot be ended: {}. Run 'kill -TERM {}'", pid,
                        session.name, std::strerror(process.is_open() ? errno : reason), pid));
    }
    if (!process.wait(limit_ms)) {
        constexpr int ms_per_s = 1000;
        throw RequestError(
            ExitCode::failed,
            fmt::format("sessions: process {} of {} has not ended within {} s of SIGTERM. 'kill "
                        "-KILL {}' ends it at once, with all its nodes",
                        pid, session.name, limit_ms / ms_per_s, pid));
    }
    return static_cast<int>(now_ms() - begin_ms);
}

}  // namespace pxpl5::host
