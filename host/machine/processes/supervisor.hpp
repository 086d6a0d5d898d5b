// Starts, watches and ends child processes. Does not use the ring.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace pxpl5::host {

struct MachineError;

/// The end of the machine, or of a join, by a signal to this process.
MachineError interruption(int signal);

/// How a process ended.
struct Death {
    std::string name;
    int exit_code = 0;
    int signal = 0;        ///< 0 if it ended by itself.
    std::string why = {};  ///< Known cause, as a sentence with the name.

    /// "gp-3 was killed by signal 9 (SIGKILL)", "gp-3 ended with exit code 70".
    std::string text() const;
    /// The exit code of the machine after this death: the process's own, 128 + signal, or 69 if the
    /// process ended with 0 without an order.
    int code() const;
};

struct ProcessCommand {
    std::string name;  ///< "gp-3".
    std::filesystem::path program;
    std::vector<std::string> arguments;  ///< Without the program's name.
    std::vector<std::string> env;        ///< "NAME=value", added to this process's environment.
    int core = -1;                       ///< Core to run on; -1: any.
    std::filesystem::path log;           ///< Takes stdout and stderr.
    bool new_log = false;                ///< Discards an earlier process's log of this name.
    std::vector<int> inherited = {};     ///< Become descriptors 3, 4, ... of the process.
    int input = -1;                      ///< Becomes standard input; -1: empty.
    bool log_arguments = true;           ///< The log begins with them.
};

/// Number of ProcessCommand::inherited[0] in the process.
inline constexpr int first_inherited_fd = 3;

/// One thread uses the supervisor. The kernel ends the children with this thread.
class Supervisor {
  public:
    /// Counts SIGINT, SIGTERM and SIGHUP from now on; they no longer end this process. An ignored
    /// SIGHUP (nohup) stays ignored. Ignores SIGPIPE and SIGXFSZ for the rest of the process.
    Supervisor();
    /// Kills the running processes and waits for them.
    ~Supervisor();
    Supervisor(const Supervisor&) = delete;
    Supervisor& operator=(const Supervisor&) = delete;

    /// Starts a process in a new session and process group, with an empty stdin.
    /// Returns its pid. Throws MachineError (69) naming program and reason.
    int spawn(const ProcessCommand& command);

    /// Waits until a process ends, a signal comes, `fd` is readable or `timeout_ms` is over (-1: no
    /// limit). Returns at once if a process has ended or a signal has come since the last call.
    void wait(int fd, int timeout_ms);

    /// Waits as wait() does, or until `input` is readable. Does not change the
    /// flags of `input`, which other programs may share. Returns whether `input` is readable. Files
    /// on disk and closed descriptors count as readable, because reading them would not block.
    bool wait_input(int fd, int input, int timeout_ms = -1);

    /// Deaths since the last call, in the order in which they were noticed.
    std::vector<Death> take_deaths();
    /// The oldest SIGINT, SIGTERM or SIGHUP that has not been taken; 0 if none is left.
    int take_interrupt();
    /// Removes the oldest signal if it is `signal`.
    void forget_interrupt(int signal);

    /// Names of the processes that have not ended.
    std::vector<std::string> running() const;
    /// Sends `signal` to the process groups of all running processes, or of `name` alone.
    void kill_all(int signal);
    void kill(const std::string& name, int signal);
    /// Sends `signal` to `name` and waits for its end, at most `most_ms`. take_deaths() reports the
    /// death.
    void end(const std::string& name, int signal, int most_ms = 10'000);

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// Milliseconds of the monotonic clock.
std::int64_t now_ms();

}  // namespace pxpl5::host
