// The memory of a process and of the processes that it has started.
#pragma once

#include <sys/types.h>

#include <cstdint>

namespace pxpl5::host {

/// Returns the memory of the process `root`, its children, and theirs. Pages that several processes
/// share count once. Takes milliseconds for each GiB.
std::uint64_t proportional_bytes(pid_t root);

/// The same, but shared pages count in each process: at least as much, and fast.
std::uint64_t resident_bytes(pid_t root);

}  // namespace pxpl5::host
