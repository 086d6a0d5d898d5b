// When the program is ended from outside.
#include "host/serve/limits/time_limit.hpp"

#include <doctest/doctest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <future>
#include <optional>
#include <utility>

#include "host/base/error.hpp"
#include "host/serve/director/state_text.hpp"

using namespace pxpl5;
using namespace pxpl5::host::serve;

namespace {

constexpr auto limit = std::chrono::seconds(60);

/// Seconds by which the clock of the test differs from that of the computer.
std::atomic<std::int64_t> set_by_s = 0;

/// The warning of a watch with this end.
EndsSoon warning_of(const EndSignal& signal, std::optional<std::int64_t> end_s) {
    std::promise<EndsSoon> promise;
    std::future<EndsSoon> warning = promise.get_future();
    const EndWatch watch(signal, end_s,
                         [&promise](EndsSoon soon) { promise.set_value(std::move(soon)); });
    REQUIRE(warning.wait_for(limit) == std::future_status::ready);
    return warning.get();
}

}  // namespace

/// The C library's function, with a clock that can be set.
extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
    const auto failed = static_cast<int>(syscall(SYS_clock_gettime, clock, now));
    now->tv_sec += clock == CLOCK_REALTIME ? set_by_s.load() : 0;
    return failed;
}

TEST_CASE("a time limit has the forms of Slurm") {
    CHECK(parse_duration("--time-limit", "90") == 5400);
    CHECK(parse_duration("--time-limit", "2:05") == 125);
    CHECK(parse_duration("--time-limit", "1:30:05") == 5405);
    CHECK(parse_duration("--time-limit", "1-12") == 129600);
    CHECK(parse_duration("--time-limit", "1-12:30") == 131400);
    CHECK(parse_duration("--time-limit", "1-12:30:01") == 131401);
}

TEST_CASE("a time limit that is no duration is refused with what is one") {
    for (const char* text :
         {"", "soon", "1:", "-1", "1-", "1:2:3:4", "1.5", "1-1-1", "2h", "99999999999999999999"}) {
        CAPTURE(text);
        CHECK_THROWS_WITH_AS(
            parse_duration("--time-limit", text),
            doctest::Contains("is no duration. Give minutes (90), hours, minutes and seconds"),
            host::RequestError);
    }
}

TEST_CASE("the end of a job is a local time") {
    setenv("TZ", "UTC-2", 1);  // Two hours before Greenwich.
    tzset();
    CHECK(end_in_job("JobId=7\n   StartTime=x EndTime=1970-01-01T03:00:00 Deadline=N/A\n") == 3600);
    setenv("TZ", "UTC", 1);
    tzset();
    CHECK_FALSE(end_in_job("   StartTime=x EndTime=Unknown Deadline=N/A\n"));
    CHECK_FALSE(end_in_job("slurm_load_jobs error: Invalid job id specified\n"));
    CHECK_FALSE(end_in_job(""));
}

TEST_CASE("the warning comes at once if less than two minutes are left") {
    const EndSignal signal;
    const std::int64_t end_s = std::time(nullptr) + warn_before_s - 1;
    const EndsSoon soon = warning_of(signal, end_s);
    CHECK(soon.at_s == end_s);
    CHECK(soon.why == "--time-limit is reached");
}

TEST_CASE("the warning comes although the clock is set back") {
    const EndSignal signal;
    const std::int64_t end_s = std::time(nullptr) + warn_before_s + 1;
    std::promise<EndsSoon> promise;
    std::future<EndsSoon> warning = promise.get_future();
    const EndWatch watch(signal, end_s,
                         [&promise](EndsSoon soon) { promise.set_value(std::move(soon)); });
    set_by_s = -86'400;
    const bool has_come = warning.wait_for(limit) == std::future_status::ready;
    set_by_s = 0;
    REQUIRE(has_come);
    const EndsSoon soon = warning.get();
    CHECK(soon.at_s == end_s);
    CHECK(soon.why == "--time-limit is reached");
}

TEST_CASE("SIGUSR1 warns of an end whose time may be unknown") {
    unsetenv("SLURM_JOB_ID");
    const EndSignal signal;
    kill(getpid(), SIGUSR1);
    const EndsSoon soon = warning_of(signal, std::nullopt);
    CHECK(soon.at_s == 0);
    CHECK(soon.why == "the program has received SIGUSR1");
}

TEST_CASE("SIGUSR1 names the known end only if that is near") {
    const EndSignal signal;
    kill(getpid(), SIGUSR1);
    const std::int64_t near_s = std::time(nullptr) + 2 * warn_before_s;
    const EndsSoon soon = warning_of(signal, near_s);
    CHECK(soon.at_s == near_s);
    CHECK(soon.why == "--time-limit is reached");
    kill(getpid(), SIGUSR1);
    const std::int64_t late_s = std::time(nullptr) + 100'000;
    const EndsSoon early = warning_of(signal, late_s);
    CHECK(early.at_s == 0);
    CHECK(early.why == "the program has received SIGUSR1");
}

TEST_CASE("the end of a job of Slurm is in its environment") {
    const EndSignal signal;
    setenv("SLURM_JOB_ID", "12", 1);
    setenv("SLURM_JOB_END_TIME", "1000", 1);
    const EndsSoon soon = warning_of(signal, std::nullopt);
    CHECK(soon.at_s == 1000);
    CHECK(soon.why == "job 12 reaches its time limit");
    unsetenv("SLURM_JOB_ID");
    unsetenv("SLURM_JOB_END_TIME");
}

TEST_CASE("a watch without an end warns of nothing and ends at once") {
    unsetenv("SLURM_JOB_ID");
    const EndSignal signal;
    bool has_warned = false;
    {
        const EndWatch watch(signal, std::nullopt, [&](const EndsSoon&) { has_warned = true; });
    }
    CHECK_FALSE(has_warned);
}

TEST_CASE("a notice of the end has one full stop, whatever its reason ends in") {
    for (const char* why : {"the host says stop", "the host says stop."}) {
        CHECK(sentence_of(EndNotice{"", why, "", "", ""}) ==
              "This session ends soon: the host says stop.");
        CHECK(sentence_of(EndNotice{"12:30", why, "", "", ""}) ==
              "This session ends at 12:30: the host says stop.");
    }
}
