#include "host/io/limits.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "host/io/sandbox/sanitizer.hpp"

namespace pxpl5::host::io {

namespace {

std::uint64_t number_of(const std::string& flag, const std::string& text) {
    std::uint64_t number = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (failure != std::errc{} || end != text.data() + text.size() || text.empty()) {
        throw std::invalid_argument(fmt::format("{} is '{}', must be a whole number", flag, text));
    }
    return number;
}

/// Takes the first `flag` and its value out of `arguments`. Nothing if it is not there.
std::optional<std::string> take(std::vector<std::string>& arguments, const std::string& flag) {
    for (auto at = arguments.begin(); at != arguments.end(); ++at) {
        if (at->starts_with(flag + "=")) {
            std::string value = at->substr(flag.size() + 1);
            arguments.erase(at);
            return value;
        }
        if (*at == flag) {
            if (at + 1 == arguments.end()) {
                throw std::invalid_argument(flag + " needs a value");
            }
            std::string value = *(at + 1);
            arguments.erase(at, at + 2);
            return value;
        }
    }
    return std::nullopt;
}

void take(std::vector<std::string>& arguments, const std::string& flag, std::uint64_t& number) {
    if (const std::optional<std::string> value = take(arguments, flag)) {
        number = number_of(flag, *value);
    }
}

}  // namespace

Limits take_limits(std::vector<std::string>& arguments) {
    Limits limits;
    take(arguments, "--memory-mib", limits.memory_mib);
    take(arguments, "--cpu-s", limits.cpu_s);
    return limits;
}

std::vector<std::string> take_allowed(std::vector<std::string>& arguments) {
    std::vector<std::string> allowed;
    while (std::optional<std::string> folder = take(arguments, "--allow")) {
        allowed.push_back(*std::move(folder));
    }
    return allowed;
}

bool take_switch(std::vector<std::string>& arguments, const std::string& flag) {
    return std::erase(arguments, flag) > 0;
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
