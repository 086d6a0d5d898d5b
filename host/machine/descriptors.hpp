// File descriptors and threads: looks at the limits before a machine starts.
#pragma once

#include <cstddef>

namespace pxpl5::host {

/// Descriptors that the host or a node needs for a machine of `nodes` nodes, without those that are
/// open already.
std::size_t needed_descriptors(std::size_t nodes);

/// Raises the soft limit of this process and of its children, so that a machine of `nodes` nodes
/// fits. Throws RequestError (unavailable) with both numbers if the hard limit is too low.
void provide_descriptors(std::size_t nodes);

/// Returns how many more threads a host needs to run a machine of `nodes` nodes, itself included:
/// for its own work, the other nodes and two io processes.
std::size_t needed_threads(std::size_t nodes, bool is_tcp);

/// Raises the soft limit of this user's threads. Throws RequestError (unavailable) with all numbers
/// if this user or the control group may not start the threads of a machine of `nodes` nodes.
/// ZeroMQ would end the process that cannot start a thread.
void provide_threads(std::size_t nodes, bool is_tcp);

/// Does both.
void provide_limits(std::size_t nodes, bool is_tcp);

}  // namespace pxpl5::host
