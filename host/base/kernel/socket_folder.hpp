// Private folders for sockets, which are removed at the end or at the next start.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace pxpl5::host {

/// Returns whether `folder` is a folder of this user that mkdtemp() has made, with a name that
/// begins with `begin`, and so old that its program is not about to use it.
bool is_stale_folder(const std::filesystem::path& folder, std::string_view begin);

/// A private folder for ipc sockets, under a short path: a socket's path may have 107 characters.
class SocketFolder {
  public:
    /// In XDG_RUNTIME_DIR, or the system's folder for temporary files. Removes the folders there
    /// that killed hosts of this user have left: no program listens at their sockets.
    /// Throws RequestError (failed) naming the folder and the reason.
    SocketFolder();
    /// The same in `parent`.
    explicit SocketFolder(const std::filesystem::path& parent);
    /// Removes the folder and its contents.
    ~SocketFolder();
    SocketFolder(const SocketFolder&) = delete;
    SocketFolder& operator=(const SocketFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// Shows other programs that this folder is in use, until this process ends. A host does so by
    /// its socket. Throws RequestError (failed).
    void mark_as_used();

  private:
    std::filesystem::path path_;
    int mark_ = -1;
};

/// The ipc address of a socket in `folder`.
std::string near_address(const std::filesystem::path& folder, const std::string& name);

}  // namespace pxpl5::host
