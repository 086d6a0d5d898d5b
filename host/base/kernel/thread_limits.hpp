// How many threads this system allows a user and a control group.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace pxpl5::host {

/// A limit of the number of threads. A process counts as its threads.
struct ThreadLimit {
    std::string name;        ///< "the limit of this user"
    std::string remedy;      ///< How to raise the limit.
    std::uint64_t most = 0;  ///< Threads that may run.
    std::uint64_t used = 0;  ///< Threads that run already.

    std::uint64_t left() const { return most > used ? most - used : 0; }
};

/// Returns the limit of this user (RLIMIT_NPROC), after its soft value has been raised to the hard
/// value, if fewer than `needed` threads may be left. Empty for a user without a limit, such as
/// root, and if the limit leaves enough threads even if all threads of this computer count.
std::optional<ThreadLimit> user_thread_limit(std::uint64_t needed);

/// Returns the limit of this process's control group, or of a group around it, that leaves the
/// fewest threads. Empty if no group has a limit.
///
/// root  The folder with proc and sys.
std::optional<ThreadLimit> group_thread_limit(const std::filesystem::path& root = "/");

/// Returns the number of threads of all processes whose real user is `user`. See
/// group_thread_limit() for `root`.
std::uint64_t threads_of_user(uid_t user, const std::filesystem::path& root = "/");

}  // namespace pxpl5::host
