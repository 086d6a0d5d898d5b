#include "host/io/limits.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <charconv>

namespace pxpl5::host::io {

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool has_sanitizer = true;
#else
constexpr bool has_sanitizer = false;
#endif

std::uint64_t number_of(const std::string& flag, const std::string& text) {
    std::uint64_t number = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failure != std::errc{} || end != text.data() + text.size() || text.empty()) {
        throw std::invalid_argument(fmt::format("{} is '{}', must be a whole number", flag, text));
    }
    return number;
}

/// Takes `flag` and its value out of `arguments`, if it is there.
void take(std::vector<std::string>& arguments, const std::string& flag, std::uint64_t& number) {
    for (auto at = arguments.begin(); at != arguments.end(); ++at) {
        if (at->starts_with(flag + "=")) {
            number = number_of(flag, at->substr(flag.size() + 1));
            arguments.erase(at);
            return;
        }
        if (*at == flag) {
            if (at + 1 == arguments.end()) {
                throw std::invalid_argument(flag + " needs a value");
            }
            number = number_of(flag, *(at + 1));
            arguments.erase(at, at + 2);
            return;
        }
    }
}

}  // namespace

Limits take_limits(std::vector<std::string>& arguments) {
    Limits limits;
    take(arguments, "--memory-mib", limits.memory_mib);
    take(arguments, "--cpu-s", limits.cpu_s);
    return limits;
}

void limit_memory(const Limits& limits) {
    if (limits.memory_mib == 0 || has_sanitizer) {
        return;
    }
    rlimit memory{};
    getrlimit(RLIMIT_AS, &memory);
    memory.rlim_cur = std::min<rlim_t>(limits.memory_mib << 20, memory.rlim_max);
    setrlimit(RLIMIT_AS, &memory);
}

void limit_next_request(const Limits& limits) {
    if (limits.cpu_s == 0) {
        return;
    }
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    const auto used_s = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
    rlimit cpu{};
    getrlimit(RLIMIT_CPU, &cpu);
    // The kernel counts the life of the process, so each request moves the soft limit on.
    cpu.rlim_cur = std::min<rlim_t>(used_s + 1 + limits.cpu_s, cpu.rlim_max);
    setrlimit(RLIMIT_CPU, &cpu);
}

}  // namespace pxpl5::host::io
