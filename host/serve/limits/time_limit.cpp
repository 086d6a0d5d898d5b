#include "host/serve/limits/time_limit.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <system_error>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/kernel/run_program.hpp"
#include "host/base/kernel/signals_blocked.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr std::int64_t s_per_minute = 60, s_per_hour = 3600, s_per_day = 86400;
constexpr int ms_per_s = 1000;
constexpr int scontrol_ms = 10'000;

/// Seconds on a clock that cannot be set, and that runs while the computer sleeps.
std::int64_t boot_s() {
    timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    return now.tv_sec;
}

/// A time in seconds since 1970, on the clock of boot_s().
std::int64_t to_boot_s(std::int64_t wall_s) {
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    return wall_s - now.tv_sec + boot_s();
}

/// The numbers of "1:30:00"; nothing if another character is among them.
std::optional<std::vector<std::int64_t>> numbers_of(std::string_view text) {
    constexpr std::int64_t most = 1'000'000;
    std::vector<std::int64_t> numbers;
    for (;;) {
        const std::size_t colon = std::min(text.find(':'), text.size());
        std::int64_t number = -1;
        const auto [stop, error] = std::from_chars(text.data(), text.data() + colon, number);
        if (error != std::errc{} || stop != text.data() + colon || number < 0 || number > most) {
            return std::nullopt;
        }
        numbers.push_back(number);
        if (colon == text.size()) {
            return numbers;
        }
        text.remove_prefix(colon + 1);
    }
}

std::string variable(const char* name) {
    const char* const text = std::getenv(name);
    return text == nullptr ? "" : text;
}

/// Output of `scontrol show job`; empty if it fails or `stop_fd` is readable.
std::string scontrol_text(const std::string& job, int stop_fd) {
    try {
        return run_program({"scontrol", "show", "job", job}, "", scontrol_ms, stop_fd).out;
    } catch (const RequestError&) {
        return {};  // The computer has no Slurm.
    }
}

/// The end of the job of Slurm that this program runs in, if any.
std::optional<std::int64_t> end_of_job(int stop_fd) {
    const std::string job = variable("SLURM_JOB_ID");
    if (job.empty()) {
        return std::nullopt;
    }
    // Slurm sets it from version 23.02 on.
    const std::string known = variable("SLURM_JOB_END_TIME");
    std::int64_t end_s = 0;
    if (std::from_chars(known.data(), known.data() + known.size(), end_s).ec == std::errc{}) {
        return end_s;
    }
    return end_in_job(scontrol_text(job, stop_fd));
}

/// Milliseconds until the warning, for poll(), which takes no more than 24 days.
/// end_s  On the clock of boot_s().
int ms_until_warning(std::optional<std::int64_t> end_s) {
    constexpr std::int64_t longest_s = s_per_day;
    return end_s ? static_cast<int>(
                       std::clamp<std::int64_t>(*end_s - warn_before_s - boot_s(), 0, longest_s)) *
                       ms_per_s
                 : -1;
}

}  // namespace

std::int64_t parse_duration(const std::string& option, const std::string& text) {
    const std::size_t dash = text.find('-');
    const bool has_days = dash != std::string::npos;
    const auto days = numbers_of(has_days ? std::string_view(text).substr(0, dash) : "0");
    const auto rest = numbers_of(std::string_view(text).substr(has_days ? dash + 1 : 0));
    if (!days || days->size() != 1 || !rest || rest->size() > 3) {
        throw RequestError(
            ExitCode::usage,
            fmt::format("{} '{}' is no duration. Give minutes (90), hours, minutes and "
                        "seconds (1:30:00), or days and hours (1-12)",
                        option, text));
    }
    std::vector<std::int64_t> hms = *rest;
    if (has_days || hms.size() == 3) {
        hms.resize(3, 0);
    } else {  // Minutes, or minutes and seconds.
        hms.insert(hms.begin(), 0);
        hms.resize(3, 0);
    }
    return days->front() * s_per_day + hms[0] * s_per_hour + hms[1] * s_per_minute + hms[2];
}

std::string duration_text(std::int64_t seconds) {
    struct Unit {
        const char* name;
        std::int64_t seconds;
    };
    std::string text;
    for (const Unit& unit : {Unit{"day", s_per_day}, Unit{"hour", s_per_hour},
                             Unit{"minute", s_per_minute}, Unit{"second", 1}}) {
        const std::int64_t count = seconds / unit.seconds;
        seconds -= count * unit.seconds;
        if (count != 0) {
            text += fmt::format("{}{} {}{}", text.empty() ? "" : " ", count, unit.name,
                                count == 1 ? "" : "s");
        }
    }
    return text.empty() ? "0 seconds" : text;
}

std::optional<std::int64_t> end_in_job(const std::string& printed) {
    constexpr std::string_view key = " EndTime=";
    const std::size_t at = printed.find(key);
    std::tm local{};
    if (at == std::string::npos ||
        strptime(printed.c_str() + at + key.size(), "%Y-%m-%dT%H:%M:%S", &local) == nullptr) {
        return std::nullopt;
    }
    local.tm_isdst = -1;  // Slurm prints local times.
    return mktime(&local);
}

EndSignal::EndSignal() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGUSR1);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    fd_ = signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
    if (fd_ < 0) {
        throw std::system_error(errno, std::generic_category(), "cannot wait for SIGUSR1");
    }
}

/// The signal stays blocked: it may come until the process ends.
EndSignal::~EndSignal() {
    close(fd_);
}

bool EndSignal::take() const {
    signalfd_siginfo signal{};
    return read(fd_, &signal, sizeof signal) == sizeof signal;
}

EndWatch::EndWatch(const EndSignal& signal, std::optional<std::int64_t> user_end_s,
                   std::function<void(EndsSoon)> warn)
    : signal_fd_(signal.fd()), stop_fd_(eventfd(0, EFD_CLOEXEC)), warn_(std::move(warn)) {
    if (stop_fd_ < 0) {
        throw std::system_error(errno, std::generic_category(), "eventfd");
    }
    const SignalsBlocked blocked;
    const std::int64_t user_end_boot_s = to_boot_s(user_end_s.value_or(0));
    thread_ = std::thread([=, this] { run(user_end_s, user_end_boot_s); });
}

EndWatch::~EndWatch() {
    (void)eventfd_write(stop_fd_, 1);
    thread_.join();
    close(stop_fd_);
}

void EndWatch::run(std::optional<std::int64_t> user_end_s, std::int64_t user_end_boot_s) {
    const std::optional<std::int64_t> end_s = user_end_s ? user_end_s : end_of_job(stop_fd_);
    const std::optional<std::int64_t> end_boot_s = user_end_s ? std::optional(user_end_boot_s)
                                                   : end_s    ? std::optional(to_boot_s(*end_s))
                                                              : std::nullopt;
    std::array<pollfd, 2> polled{{{signal_fd_, POLLIN, 0}, {stop_fd_, POLLIN, 0}}};
    int ready = 0;
    do {
        ready = poll(polled.data(), polled.size(), ms_until_warning(end_boot_s));
    } while ((ready < 0 && errno == EINTR) || (ready == 0 && ms_until_warning(end_boot_s) > 0));
    if (polled[1].revents != 0) {
        return;
    }
    EndsSoon soon{0, "the program has received SIGUSR1"};
    // A signal that comes long before the known end is for another reason.
    const bool is_near = end_boot_s && *end_boot_s - boot_s() <= std::int64_t{2} * warn_before_s;
    if (is_near) {
        soon.at_s = *end_s;
        soon.why = user_end_s
                       ? "--time-limit is reached"
                       : fmt::format("job {} reaches its time limit", variable("SLURM_JOB_ID"));
    }
    warn_(std::move(soon));
}

}  // namespace pxpl5::host::serve
