#include "host/serve/limits/memory_limit.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/base/kernel/signals_blocked.hpp"
#include "host/machine/sessions/process_memory.hpp"

namespace pxpl5::host::serve {

namespace {

namespace fs = std::filesystem;

constexpr int pause_ms = 2000;
constexpr int kill_ms = 20'000;

/// The number at the begin of a file; nothing for "max", or if there is no such file.
std::optional<std::uint64_t> number_in(const fs::path& path) {
    std::ifstream file(path);
    std::uint64_t number = 0;
    return file >> number ? std::optional(number) : std::nullopt;
}

/// MemAvailable in bytes; 0 if it is unknown.
std::uint64_t available_memory(const fs::path& root) {
    std::ifstream file(root / "proc/meminfo");
    for (std::string word; file >> word;) {
        constexpr std::uint64_t bytes_per_kib = 1024;
        std::uint64_t kib = 0;
        if (word == "MemAvailable:" && file >> kib) {
            return kib * bytes_per_kib;
        }
    }
    return 0;
}

}  // namespace

std::uint64_t free_memory(const fs::path& root) {
    std::uint64_t least = available_memory(root);
    std::ifstream file(root / "proc/self/cgroup");
    constexpr std::string_view begin = "0::/";
    for (std::string line; std::getline(file, line);) {
        if (!line.starts_with(begin)) {
            continue;
        }
        const fs::path mount = root / "sys/fs/cgroup";
        fs::path group = line.substr(begin.size());
        for (bool is_root = false; !is_root; group = group.parent_path()) {
            is_root = group.empty();
            const fs::path folder = is_root ? mount : mount / group;
            const auto most = number_in(folder / "memory.max");
            const auto used = number_in(folder / "memory.current");
            if (most && used) {
                const std::uint64_t left = *most > *used ? *most - *used : 0;
                least = least == 0 ? left : std::min(least, left);
            }
        }
    }
    return least;
}

std::string gib_text(std::uint64_t bytes) {
    return fmt::format("{:.3g} GiB", static_cast<double>(bytes) / double{1U << 30U});
}

MemoryWatch::MemoryWatch(std::uint64_t limit_bytes, std::function<void(const std::string&)> act)
    : stop_fd_(eventfd(0, EFD_CLOEXEC)), act_(std::move(act)) {
    if (stop_fd_ < 0) {
        throw std::system_error(errno, std::generic_category(), "eventfd");
    }
    if (limit_bytes != 0) {
        const SignalsBlocked blocked;
        thread_ = std::thread([this, limit_bytes] { run(limit_bytes); });
    }
}

MemoryWatch::~MemoryWatch() {
    (void)eventfd_write(stop_fd_, 1);
    if (thread_.joinable()) {
        thread_.join();
    }
    close(stop_fd_);
}

void MemoryWatch::run(std::uint64_t limit_bytes) const {
    pollfd stop{stop_fd_, POLLIN, 0};
    while (poll(&stop, 1, pause_ms) <= 0) {
        if (resident_bytes(getpid()) <= limit_bytes) {
            continue;
        }
        if (const std::uint64_t used = proportional_bytes(getpid()); used > limit_bytes) {
            act_(fmt::format("the session uses {} of memory, more than its limit of {}",
                             gib_text(used), gib_text(limit_bytes)));
            if (poll(&stop, 1, kill_ms) <= 0) {
                kill(getpid(), SIGKILL);
            }
            return;
        }
    }
}

}  // namespace pxpl5::host::serve
