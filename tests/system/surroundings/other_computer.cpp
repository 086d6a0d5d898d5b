// A computer with a wrong wall clock, or a disk that fails: a library for LD_PRELOAD.
//
// OTHER_CLOCK is the time at the first look, in seconds since 1970, and what a second of the true
// clock adds: "253402300800 0" stands still. With SYNC_FAILS, no file reaches the disk.
#include <dlfcn.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <ctime>

namespace {

using Look = int (*)(clockid_t, timespec*);
constexpr long ns_per_s = 1'000'000'000;

struct Clock {
    Look look = reinterpret_cast<Look>(dlsym(RTLD_NEXT, "clock_gettime"));
    timespec true_start{};
    long long start_s = 0;
    double rate = 1;
    Clock() {
        look(CLOCK_MONOTONIC, &true_start);
        char* end = nullptr;
        if (const char* text = std::getenv("OTHER_CLOCK"); text != nullptr) {
            start_s = std::strtoll(text, &end, 10);
            rate = std::strtod(end, nullptr);
        }
    }
    timespec now() const {
        timespec true_now{};
        look(CLOCK_MONOTONIC, &true_now);
        const double passed_s =
            rate * (static_cast<double>(true_now.tv_sec - true_start.tv_sec) +
                    static_cast<double>(true_now.tv_nsec - true_start.tv_nsec) / ns_per_s);
        const long long ns = static_cast<long long>(passed_s * ns_per_s) + 500 * ns_per_s;
        return {static_cast<time_t>(start_s - 500 + ns / ns_per_s), ns % ns_per_s};
    }
};

const Clock& clock_of_process() {
    static const Clock clock;
    return clock;
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t id, timespec* time) noexcept {
    const Clock& clock = clock_of_process();
    if (id != CLOCK_REALTIME) {
        return clock.look(id, time);
    }
    *time = clock.now();
    return 0;
}

int gettimeofday(timeval* time, void* /*zone*/) noexcept {
    const timespec now = clock_of_process().now();
    *time = {now.tv_sec, now.tv_nsec / 1000};
    return 0;
}

time_t time(time_t* seconds) noexcept {
    const time_t now = clock_of_process().now().tv_sec;
    if (seconds != nullptr) {
        *seconds = now;
    }
    return now;
}

int fsync(int file) {
    if (std::getenv("SYNC_FAILS") != nullptr) {
        errno = EIO;
        return -1;
    }
    return static_cast<int>(syscall(SYS_fsync, file));
}
}
