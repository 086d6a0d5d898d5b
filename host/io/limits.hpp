// Limits on what a decoder may use: broken files make decoders loop and allocate.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace pxpl5::host::io {

struct Limits {
    std::uint64_t memory_mib = 16'384;  ///< Address space of the process; 0: no limit.
    std::uint64_t cpu_s = 300;          ///< Processor seconds of one request; 0: no limit.
};

/// Takes --memory-mib N and --cpu-s N (or --name=N) out of `arguments`.
/// Throws std::invalid_argument naming the flag and its value.
Limits take_limits(std::vector<std::string>& arguments);

/// Takes each --allow DIR (or --allow=DIR) out of `arguments`. Throws std::invalid_argument if the
/// last has no value.
std::vector<std::string> take_allowed(std::vector<std::string>& arguments);

/// Takes each `flag`, which has no value, out of `arguments`. Returns whether there was one.
bool take_switch(std::vector<std::string>& arguments, const std::string& flag);

/// Limits the process's memory: beyond it, allocation fails with std::bad_alloc. Has no effect
/// under a sanitizer, which reserves terabytes of addresses.
void limit_memory(const Limits& limits);

/// Gives the request that begins now its processor seconds. A request that uses more ends the
/// process with SIGXCPU.
void limit_next_request(const Limits& limits);

}  // namespace pxpl5::host::io
