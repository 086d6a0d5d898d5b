// The running sessions of this user, on this computer and on others that share the folder.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host/machine/sessions/session_note.hpp"

namespace pxpl5::host {

/// A program that runs. Its name is that of its first run folder: each restart of the machine makes
/// another one.
struct RunningSession {
    std::string name;
    std::filesystem::path folder;
    std::string subcommand;  ///< "run", "serve", "render" or "report".
    std::string state;    ///< starting, ready, running, ending, stopped or unknown. See README.md.
    std::string started;  ///< "2026-11-24T03:00:00Z".
    std::string computer;
    bool is_here = false;  ///< Runs on this computer, in this container.
    std::int64_t pid = 0;
    std::int64_t process_start = 0;             ///< See start_of(); 0 if unknown.
    std::string job;                            ///< Slurm's job id; empty outside of a job.
    std::optional<std::uint64_t> memory_bytes;  ///< Sum of all its processes; only if here.
    SessionFacts facts;
};

/// Returns the sessions whose run folders lie in `base`, the oldest first. Programs that have ended
/// or were killed are left out. Empty if `base` does not exist.
std::vector<RunningSession> running_sessions(const std::filesystem::path& base);

/// Returns the session of this process of this computer, without its memory; nothing if it has no
/// run folder in `base`. Faster than running_sessions().
std::optional<RunningSession> session_of_process(const std::filesystem::path& base, pid_t pid);

/// Returns the session with this name, process id or job id; "latest" is the newest. Throws
/// RequestError (usage) if there is no such session, or more than one.
RunningSession find_session(const std::filesystem::path& base, const std::string& name);

}  // namespace pxpl5::host
