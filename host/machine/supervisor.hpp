// Child processes: started, watched, ended. Knows nothing of the ring.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace pxpl5::host {

/// How a process ended.
struct Death {
    std::string name;
    int exit_code = 0;
    int signal = 0;  ///< 0 if it ended by itself.

    /// "gp-3 was killed by signal 9 (SIGKILL)", "gp-3 ended with exit code 70".
    std::string text() const;
    /// The exit code that this death leads to: the process's own, 128 + signal, or 69 if it ended
    /// with 0 although nobody had told it to.
    int code() const;
};

struct Command {
    std::string name;  ///< "gp-3".
    std::filesystem::path program;
    std::vector<std::string> arguments;  ///< Without the program's name.
    std::vector<std::string> env;        ///< "NAME=value", added to this process's environment.
    int core = -1;                       ///< Core to run on; -1: any.
    std::filesystem::path log;           ///< Takes stdout and stderr.
};

/// One thread uses it: the one that must outlive the children, since the kernel ends them with it.
class Supervisor {
  public:
    /// From here on SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) to this
    /// process are counted instead of ending it; SIGPIPE and SIGXFSZ are ignored for good.
    Supervisor();
    /// Kills what still runs, and waits for it.
    ~Supervisor();
    Supervisor(const Supervisor&) = delete;
    Supervisor& operator=(const Supervisor&) = delete;

    /// Starts a process in a session and process group of its own, stdin empty.
    /// Returns its pid. Throws MachineError (69) naming program and reason.
    int spawn(const Command& command);

    /// Waits until a process ends, a signal comes, `fd` is readable or `timeout_ms` is over (-1:
    /// never). Returns at once if one of the first two has happened since the last call.
    void wait(int fd, int timeout_ms);

    /// As wait() without a limit, and until `input` is readable, whose flags are left alone: other
    /// programs may share it. Returns whether it is; so are files on disk, always, and what is not
    /// open, since reading it would not block.
    bool wait_input(int fd, int input);

    /// Deaths since the last call, in the order in which they were noticed.
    std::vector<Death> take_deaths();
    /// SIGINT, SIGTERM or SIGHUP, in the order in which they came; 0 if there is none left.
    int take_interrupt();

    /// Names of the processes that have not ended.
    std::vector<std::string> running() const;
    /// Sends `signal` to the process group of everyone that runs, or of `name` alone.
    void kill_all(int signal);
    void kill(const std::string& name, int signal);
    /// Kills `name` and waits until it is dead; take_deaths() tells of it.
    void end(const std::string& name);

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// Milliseconds of the monotonic clock.
std::int64_t now_ms();

}  // namespace pxpl5::host
