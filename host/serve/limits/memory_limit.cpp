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
#include <system_error>
#include <utility>

#include "host/base/kernel/control_groups.hpp"
#include "host/base/kernel/signals_blocked.hpp"
#include "host/machine/sessions/process_memory.hpp"

namespace pxpl5::host::serve {

namespace {

namespace fs = std::filesystem;

constexpr int pause_ms = 2000;
constexpr int kill_ms = 20'000;

/// MemAvailable in bytes.
std::optional<std::uint64_t> available_memory(const fs::path& root) {
    std::ifstream file(root / "proc/meminfo");
    for (std::string word; file >> word;) {
        constexpr std::uint64_t bytes_per_kib = 1024;
        std::uint64_t kib = 0;
        if (word == "MemAvailable:" && file >> kib) {
            return kib * bytes_per_kib;
        }
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> free_memory(const fs::path& root) {
    const std::optional<std::uint64_t> available = available_memory(root);
    const std::optional<GroupLimit> group = tightest_group_limit("memory", root);
    return group ? std::min(group->left(), available.value_or(group->left())) : available;
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
