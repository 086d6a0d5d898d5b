#include "host/machine/descriptors.hpp"

#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <thread>

#include "host/base/error.hpp"
#include "host/base/kernel/thread_limits.hpp"

namespace pxpl5::host {

namespace {

// ZeroMQ, the event loop, traces, files of a command and an io process.
constexpr std::size_t own_descriptors = 40;
// The socket to a node and its mailbox, the connection from the node, and its log at the start.
constexpr std::size_t descriptors_per_node = 4;
constexpr std::size_t reserve = 512;  // For viewers, if the hard limit allows them.

// Two of ZeroMQ, the viewer's server, and with tcp one that counts connections.
constexpr std::size_t host_threads = 4;
// The node's loop, two of ZeroMQ, and the heartbeat.
constexpr std::size_t threads_per_node = 4;
// One more in each process with tcp, which asks for keys.
constexpr std::size_t tcp_threads = 1;
// One io process reads or writes, and one is prepared or ends.
constexpr std::size_t io_processes = 2;

/// Two libraries of an io process start one thread per core, and an encoder starts one.
std::size_t io_library_threads() {
    return 2 * std::max(1U, std::thread::hardware_concurrency()) + 1;
}

/// Descriptors that are open, as far as /proc shows them.
std::size_t open_descriptors() {
    std::error_code error;
    const std::filesystem::directory_iterator entries("/proc/self/fd", error);
    return error ? 3 : static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
}

}  // namespace

std::size_t needed_descriptors(std::size_t nodes) {
    return own_descriptors + descriptors_per_node * nodes;
}

void provide_descriptors(std::size_t nodes) {
    rlimit limit{};
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0) {
        return;
    }
    const rlim_t needed = needed_descriptors(nodes) + open_descriptors();
    if (limit.rlim_max < needed) {
        throw RequestError(
            ExitCode::unavailable,
            fmt::format("a machine of {} nodes needs {} file descriptors, but the hard limit is "
                        "{}. Raise the limit (ulimit -Hn {}), or choose a topology with fewer "
                        "nodes",
                        nodes, needed, limit.rlim_max, needed));
    }
    const rlim_t wanted = std::min<rlim_t>(limit.rlim_max, needed + reserve);
    if (limit.rlim_cur < wanted) {
        limit.rlim_cur = wanted;
        setrlimit(RLIMIT_NOFILE, &limit);
    }
}

std::size_t needed_threads(std::size_t nodes, bool is_tcp) {
    const std::size_t processes = nodes - 1 + io_processes;
    return host_threads + processes * threads_per_node + io_processes * io_library_threads() +
           (is_tcp ? (processes + 1) * tcp_threads : 0);
}

void provide_threads(std::size_t nodes, bool is_tcp) {
    const std::size_t needed = needed_threads(nodes, is_tcp);
    for (const auto& limit : {user_thread_limit(needed), group_thread_limit()}) {
        if (limit && limit->left() < needed) {
            throw RequestError(
                ExitCode::unavailable,
                fmt::format("a machine of {} nodes needs {} threads, but {} is {}, and {} threads "
                            "run already. Raise the limit to {} ({}), or choose a topology with "
                            "fewer nodes",
                            nodes, needed, limit->name, limit->most, limit->used,
                            limit->used + needed, limit->remedy));
        }
    }
}

void provide_limits(std::size_t nodes, bool is_tcp) {
    provide_descriptors(nodes);
    provide_threads(nodes, is_tcp);
}

}  // namespace pxpl5::host
