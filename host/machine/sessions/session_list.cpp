#include "host/machine/sessions/session_list.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <tuple>

#include "host/base/error.hpp"
#include "host/machine/sessions/json_values.hpp"
#include "host/machine/sessions/process_memory.hpp"
#include "host/machine/sessions/run_state.hpp"

namespace pxpl5::host {

namespace {

namespace fs = std::filesystem;

/// The state in /proc/PID/stat; '?' if there is no such process.
char process_state(std::int64_t pid) {
    std::ifstream file(fmt::format("/proc/{}/stat", pid));
    std::string line;
    std::getline(file, line);
    const std::size_t name_end = line.rfind(") ");
    return name_end + 2 < line.size() && name_end != std::string::npos ? line[name_end + 2] : '?';
}

std::string state_text(const RunningSession& session, RunState run) {
    if (run == RunState::unknown) {
        return "unknown";
    }
    if (session.is_here && process_state(session.pid) == 'T') {
        return "stopped";
    }
    if (session.facts.is_ending) {
        return "ending";
    }
    if (session.subcommand != "serve") {
        return "running";
    }
    return session.facts.url.empty() ? "starting" : "ready";
}

/// The session of a run folder; nothing if its program has ended.
std::optional<RunningSession> session_of(const fs::path& folder, pid_t maker) {
    const nlohmann::json manifest = read_json(folder / "manifest.json");
    const nlohmann::json host =
        manifest.is_object() ? manifest.value("host", nlohmann::json()) : manifest;
    RunningSession session;
    session.name = folder.filename().string();
    session.folder = folder;
    session.subcommand = text_in(manifest, "subcommand");
    session.started = text_in(manifest, "started");
    session.computer = text_in(host, "name");
    session.pid = maker;
    session.process_start = number_in(manifest, "process_start");
    session.job = text_in(manifest, "job");
    session.is_here = session.computer == computer_name() &&
                      text_in(host, "pid_namespace") == pid_namespace() &&
                      text_in(host, "boot_id") == boot_id();
    const RunState run = RunProbe(folder, maker, RunProbe::Use::look).state;
    // A program that removes old runs also locks them for a moment.
    const bool is_gone = session.is_here && session.process_start != start_of(maker).value_or(-1);
    if (run == RunState::ended || is_gone) {
        return std::nullopt;
    }
    session.facts = read_note(folder);
    session.state = state_text(session, run);
    return session;
}

/// In a folder that several users share, a manifest of another user could name any process and any
/// address.
bool is_own_folder(const fs::path& path) {
    struct stat facts {};
    return lstat(path.c_str(), &facts) == 0 && S_ISDIR(facts.st_mode) && facts.st_uid == geteuid();
}

/// The run folders of this user, the oldest first.
std::vector<fs::path> run_folders(const fs::path& base) {
    std::vector<fs::path> folders;
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(base, ignored)) {
        if (maker_of(entry.path().filename().string()) && is_own_folder(entry.path())) {
            folders.push_back(entry.path());
        }
    }
    std::ranges::sort(folders);  // Their names begin with the time.
    return folders;
}

bool is_called(const RunningSession& session, const std::string& name) {
    return session.name == name || fmt::format("{}", session.pid) == name ||
           (!session.job.empty() && session.job == name);
}

}  // namespace

std::vector<RunningSession> running_sessions(const fs::path& base) {
    const std::vector<fs::path> folders = run_folders(base);
    std::map<std::tuple<std::string, std::int64_t, std::int64_t>, bool> seen;
    std::vector<RunningSession> sessions;
    for (const fs::path& folder : folders) {
        std::optional<RunningSession> found =
            session_of(fs::absolute(folder), *maker_of(folder.filename().string()));
        if (!found ||
            !seen.emplace(std::tuple(found->computer, found->pid, found->process_start), true)
                 .second) {
            continue;
        }
        if (found->is_here) {
            found->memory_bytes = proportional_bytes(static_cast<pid_t>(found->pid));
        }
        sessions.push_back(std::move(*found));
    }
    return sessions;
}

std::optional<RunningSession> session_of_process(const fs::path& base, pid_t pid) {
    for (const fs::path& folder : run_folders(base)) {
        if (maker_of(folder.filename().string()) != pid) {
            continue;
        }
        // An ended run may have had the same process id.
        if (auto session = session_of(folder, pid); session && session->is_here) {
            return session;
        }
    }
    return std::nullopt;
}

RunningSession find_session(const fs::path& base, const std::string& name) {
    std::vector<RunningSession> sessions = running_sessions(base);
    if (name == "latest" && !sessions.empty()) {
        return sessions.back();
    }
    std::erase_if(sessions, [&](const auto& each) { return !is_called(each, name); });
    if (sessions.size() == 1) {
        return sessions.front();
    }
    throw RequestError(
        ExitCode::usage,
        sessions.empty()
            ? fmt::format("sessions: no session '{}' runs with its run folder in {}. 'pxpl5 "
                          "sessions' lists those that run",
                          name, base.string())
            : fmt::format("sessions: '{}' means {} sessions, {} and {}. Give the name of one", name,
                          sessions.size(), sessions[0].name, sessions[1].name));
}

}  // namespace pxpl5::host
