// Private folders for sockets, which are removed at the end or at the next start.
#pragma once

#include <filesystem>
#include <string>

#include "host/base/kernel/locked_folder.hpp"

namespace pxpl5::host {

/// A private folder for ipc sockets, under a short path: a socket's path may have 107 characters.
class SocketFolder {
  public:
    /// In XDG_RUNTIME_DIR, or the system's folder for temporary files. Removes the folders that
    /// killed programs of this user have left, also the temporary ones.
    /// Throws RequestError (failed) naming the folder and the reason.
    SocketFolder();
    /// In `parent`. Removes the folders of sockets there that killed programs have left.
    explicit SocketFolder(const std::filesystem::path& parent);
    /// Removes the folder and its contents.
    ~SocketFolder();
    SocketFolder(const SocketFolder&) = delete;
    SocketFolder& operator=(const SocketFolder&) = delete;

    const std::filesystem::path& path() const { return folder_.path(); }
    /// Shows other programs by a socket that this folder is in use, until this process ends: also
    /// where files have no locks. A host does so by its own socket. Throws RequestError (failed).
    void mark_as_used();

  private:
    LockedFolder folder_;
    int mark_ = -1;
};

/// The ipc address of a socket in `folder`.
std::string near_address(const std::filesystem::path& folder, const std::string& name);

}  // namespace pxpl5::host
