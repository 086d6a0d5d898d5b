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

/// The number in a file of a control group. Empty for "max", and if the file does not exist.
std::optional<std::uint64_t> number_in(const fs::path& path) {
    std::ifstream file(path);
    std::uint64_t number = 0;
    return file >> number ? std::optional(number) : std::nullopt;
}

/// Keeps in `least` the tighter of `least` and the limits of `group` and of the groups around it.
/// In a container, a group may have a path that is not mounted.
void note_groups(const fs::path& mount, fs::path group, std::optional<ThreadLimit>& least) {
    for (bool is_root = false; !is_root; group = group.parent_path()) {
        is_root = group.empty();
        const fs::path folder = is_root ? mount : mount / group;
        const auto most = number_in(folder / "pids.max");
        const auto used = number_in(folder / "pids.current");
        if (most && used) {
            const ThreadLimit limit{
                fmt::format("the limit of its control group ({})", (folder / "pids.max").string()),
                "TasksMax of systemd, --pids-limit of docker", *most, *used};
            if (!least || limit.left() < least->left()) {
                least = limit;
            }
        }
    }
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
    std::ifstream file(root / "proc/self/cgroup");
    const fs::path mount = root / "sys/fs/cgroup";
    std::optional<ThreadLimit> least;
    // Lines are "4:pids:/group" in version 1 and "0::/group" in version 2.
    for (std::string line; std::getline(file, line);) {
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) {
            continue;
        }
        const std::string controllers = line.substr(first + 1, second - first - 1);
        const fs::path group = fs::path(line.substr(second + 1)).relative_path();
        if (controllers.empty() || controllers == "pids") {
            note_groups(mount / controllers, group, least);
        }
    }
    return least;
}

}  // namespace pxpl5::host
