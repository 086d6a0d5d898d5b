#include "host/base/kernel/thread_limits.hpp"

#include <fmt/core.h>
#include <linux/capability.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <ios>
#include <sstream>
#include <system_error>

#include "host/base/kernel/control_groups.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// The value of "NAME: VALUE", one per line, as /proc/PID/status has them.
std::uint64_t field_of(const fs::path& status, const std::string& name, bool is_hexadecimal) {
    std::ifstream file(status);
    std::uint64_t value = 0;
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with(name + ":")) {
            std::istringstream text(line.substr(name.size() + 1));
            text >> (is_hexadecimal ? std::hex : std::dec) >> value;
        }
    }
    return value;
}

/// True if the kernel does not apply RLIMIT_NPROC to this process.
bool is_unlimited() {
    constexpr std::uint64_t exempt = std::uint64_t{1} << CAP_SYS_RESOURCE | std::uint64_t{1}
                                                                                << CAP_SYS_ADMIN;
    return getuid() == 0 || (field_of("/proc/self/status", "CapEff", true) & exempt) != 0;
}

/// All threads of this computer, from a text as "0.20 0.18 0.12 1/80 11206".
std::uint64_t threads_of_computer() {
    std::ifstream file("/proc/loadavg");
    std::string load, counts;
    file >> load >> load >> load >> counts;
    const std::size_t slash = counts.find('/');
    std::uint64_t threads = UINT64_MAX;
    if (slash != std::string::npos) {
        std::istringstream(counts.substr(slash + 1)) >> threads;
    }
    return threads;
}

}  // namespace

std::uint64_t threads_of_user(uid_t user, const fs::path& root) {
    std::uint64_t threads = 0;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(root / "proc", error)) {
        const std::string name = entry.path().filename().string();
        if (std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; })) {
            const fs::path status = entry.path() / "status";  // Absent if the process has ended.
            if (fs::exists(status, error) && field_of(status, "Uid", false) == user) {
                threads += field_of(status, "Threads", false);
            }
        }
    }
    return threads;
}

std::optional<ThreadLimit> user_thread_limit(std::uint64_t needed) {
    rlimit limit{};
    if (getrlimit(RLIMIT_NPROC, &limit) != 0 || is_unlimited()) {
        return std::nullopt;
    }
    if (limit.rlim_cur < limit.rlim_max) {
        const rlimit raised{limit.rlim_max, limit.rlim_max};
        setrlimit(RLIMIT_NPROC, &raised);
    }
    // Counting reads a file per process.
    const std::uint64_t all = threads_of_computer();
    if (limit.rlim_max == RLIM_INFINITY ||
        (all < limit.rlim_max && limit.rlim_max - all >= needed)) {
        return std::nullopt;
    }
    return ThreadLimit{"the limit of this user", "ulimit -Hu", limit.rlim_max,
                       threads_of_user(getuid())};
}

std::optional<ThreadLimit> group_thread_limit(const fs::path& root) {
    const std::optional<GroupLimit> least = tightest_group_limit("pids", root);
    return least ? std::optional(ThreadLimit{
                       fmt::format("the limit of its control group ({})", least->file.string()),
                       "TasksMax of systemd, --pids-limit of docker", least->most, least->used})
                 : std::nullopt;
}

}  // namespace pxpl5::host
