#include "host/serve/limits/memory_limit.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "host/base/kernel/signals_blocked.hpp"
#include "host/machine/sessions/process_memory.hpp"

namespace pxpl5::host::serve {

namespace {

constexpr int pause_ms = 2000;

}  // namespace

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
            return;
        }
    }
}

}  // namespace pxpl5::host::serve
