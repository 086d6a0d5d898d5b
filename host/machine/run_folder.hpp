// The folders of one run: one stays (logs, plan, facts), one is removed (sockets).
#pragma once

#include <filesystem>
#include <string>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Makes <base>/<utc>-<pid> with config.resolved.json and manifest.json, for the owner alone: logs
/// and traces name and hold patients' data. Returns its absolute path.
///
/// Locks the folder until this process ends. Removes uploads from the runs in `base` whose programs
/// have ended, and these runs except for the newest `keep`; 0 keeps all. Programs on other
/// computers and in other containers may share `base`: a run has ended if its lock is free. A run
/// without a lock file has ended if its manifest is from here and its process is gone.
///
/// Throws RequestError (failed) naming the folder and the reason.
std::filesystem::path make_run_folder(const std::filesystem::path& base, const Topology& topology,
                                      int keep = 0);

/// A private folder for ipc sockets, under a short path: a socket's path may have 107 characters.
class SocketFolder {
  public:
    /// In XDG_RUNTIME_DIR, or the system's folder for temporary files. Removes the folders there
    /// that killed hosts of this user have left: no program listens at their sockets.
    /// Throws RequestError (failed) naming the folder and the reason.
    SocketFolder();
    /// Removes the folder and its contents.
    ~SocketFolder();
    SocketFolder(const SocketFolder&) = delete;
    SocketFolder& operator=(const SocketFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// The last line of a process's log, its reason for ending. Empty if the process wrote no line.
std::string last_words(const std::filesystem::path& log);

}  // namespace pxpl5::host
