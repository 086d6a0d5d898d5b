// Limits of the control groups of this process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace pxpl5::host {

/// A limit of a control group, and how much of it is used.
struct GroupLimit {
    std::filesystem::path file;  ///< The file with the limit.
    std::uint64_t most = 0, used = 0;

    std::uint64_t left() const { return most > used ? most - used : 0; }
};

/// Returns the limit that leaves the least, of the control group of this process and of the groups
/// around it. Empty if none has a limit.
///
/// controller  "pids", "memory": its files NAME.max and NAME.current are read. Version 2 has these
///             files for both, version 1 for "pids" alone.
/// root        The folder with proc and the mounted control groups.
std::optional<GroupLimit> tightest_group_limit(const std::string& controller,
                                               const std::filesystem::path& root = "/");

}  // namespace pxpl5::host
