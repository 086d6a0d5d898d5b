// When something outside of this program ends it: the time limit of a job, or one that the user
// names.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "host/serve/server/server.hpp"

namespace pxpl5::host::serve {

/// Begin of the last line of a session that was not used.
inline constexpr std::string_view idle_end_words = "the session has ended after";

/// Seconds before the end at which the viewers are warned.
inline constexpr int warn_before_s = 120;

/// Reads a duration in the forms of Slurm: minutes, M:S, H:M:S, D-H, D-H:M, D-H:M:S. Returns
/// seconds. Throws RequestError (usage) that names the option.
std::int64_t parse_duration(const std::string& option, const std::string& text);

/// "1 hour 30 minutes", "5 seconds".
std::string duration_text(std::int64_t seconds);

/// Reads EndTime in what `scontrol show job` prints, as seconds since 1970; nothing if the job has
/// no end.
std::optional<std::int64_t> end_in_job(const std::string& printed);

/// Keeps SIGUSR1 from ending this program. This thread, threads that it starts later, and nothing
/// else, block the signal.
class EndSignal {
  public:
    EndSignal();
    ~EndSignal();
    EndSignal(const EndSignal&) = delete;
    EndSignal& operator=(const EndSignal&) = delete;

    /// Readable when SIGUSR1 has come.
    int fd() const { return fd_; }
    /// Returns whether the signal has come since the last call.
    bool take() const;

  private:
    int fd_;
};

/// Calls `warn` once, from a thread of its own: warn_before_s before the end, or when SIGUSR1
/// comes. The end is the one of the user; without one, that of the job of Slurm. If the signal
/// comes more than 2 * warn_before_s before that end, the warning names the signal, and no time.
/// The time that is left is computed once, when the end is known: setting the clock later does not
/// move the warning.
class EndWatch {
  public:
    /// user_end_s  Seconds since 1970.
    EndWatch(const EndSignal& signal, std::optional<std::int64_t> user_end_s,
             std::function<void(EndsSoon)> warn);
    /// Ends the thread.
    ~EndWatch();
    EndWatch(const EndWatch&) = delete;
    EndWatch& operator=(const EndWatch&) = delete;

  private:
    void run(std::optional<std::int64_t> user_end_s, std::int64_t user_end_boot_s);

    int signal_fd_, stop_fd_;
    std::function<void(EndsSoon)> warn_;
    std::thread thread_;
};

}  // namespace pxpl5::host::serve
