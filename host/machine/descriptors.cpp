#include "host/machine/descriptors.hpp"

#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "host/base/error.hpp"

namespace pxpl5::host {

namespace {

// ZeroMQ, the event loop, traces, files of a command and an io process.
constexpr std::size_t own_descriptors = 40;
// The socket to a node and its mailbox, the connection from the node, and its log at the start.
constexpr std::size_t descriptors_per_node = 4;
constexpr std::size_t reserve = 512;  // For viewers, if the hard limit allows them.

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

}  // namespace pxpl5::host
