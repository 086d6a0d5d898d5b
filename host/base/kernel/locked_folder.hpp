// Private folders with a lock, so that the next start removes those of killed programs.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace pxpl5::host {

/// In a LockedFolder. No run folder has a file of this name, so that copies of runs are no
/// temporary folders.
inline constexpr const char* temporary_lock = ".pxpl5-temporary";

/// Returns whether `folder` is a folder of this user that mkdtemp() has made, for the owner alone,
/// with a name that begins with `begin`, and so old that its program is not about to use it.
bool is_stale_folder(const std::filesystem::path& folder, std::string_view begin,
                     std::chrono::seconds youth = std::chrono::seconds(10));

/// A new folder for the owner alone. Its file `temporary_lock` is locked until this object or the
/// process ends, however the process ends. No child inherits the lock.
class LockedFolder {
  public:
    LockedFolder() = default;
    /// Removes the folder and its contents.
    ~LockedFolder();
    LockedFolder(const LockedFolder&) = delete;
    LockedFolder& operator=(const LockedFolder&) = delete;

    /// Makes the folder `name`-RANDOM in `parent`. A file system without locks leaves the folder
    /// without a lock file. Returns 0, or the errno of the failure.
    int make(const std::filesystem::path& parent, const std::string& name);
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
    int lock_ = -1;
};

/// Decides about a folder that no living program has locked. `has_lock`: its program had locked it.
using IsUnused = std::function<bool(const std::filesystem::path& folder, bool has_lock)>;

/// Removes the stale folders in `parent` with a name that begins with one of `begins` and that no
/// program has locked, if `is_unused` agrees. Follows no links.
void remove_stale_folders(const std::filesystem::path& parent,
                          std::span<const std::string_view> begins, const IsUnused& is_unused);

}  // namespace pxpl5::host
