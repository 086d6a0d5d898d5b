// Whether the kernel has ended processes because memory ran out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace pxpl5::host {

/// A number of processes that the kernel has killed for lack of memory.
struct MemoryKills {
    std::uint64_t count = 0;
    bool is_own = false;  ///< Counts only the control group of this process and its children.
                          ///< Otherwise all processes of this computer, since its start.
};

/// Reads the count of the control group (version 1 or 2). Reads that of the computer if the control
/// group has none, for example because this process is in no group. Empty if the kernel does not
/// count (before 4.13).
///
/// root  The folder with proc and the mounted control groups.
std::optional<MemoryKills> memory_kills(const std::filesystem::path& root = "/");

}  // namespace pxpl5::host
