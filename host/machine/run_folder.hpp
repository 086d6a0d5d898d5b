// The folders of one run: one stays (logs, plan, facts), one is removed (sockets).
#pragma once

#include <filesystem>
#include <string>

#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Makes <base>/<utc>-<pid> with config.resolved.json and manifest.json. Returns its absolute path.
/// Throws RequestError (failed) naming the folder and the reason.
std::filesystem::path make_run_folder(const std::filesystem::path& base, const Topology& topology);

/// A private folder for ipc sockets, under a short path: a socket's path may have 107 characters.
class SocketFolder {
  public:
    /// In XDG_RUNTIME_DIR, or the system's folder for temporary files.
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

}  // namespace pxpl5::host
