// Folders of the program: one whose contents outlive it, others that are gone when it ends.
#pragma once

#include <filesystem>
#include <string>

#include "host/base/kernel/locked_folder.hpp"

namespace pxpl5::host {

/// Returns the folder of run folders unless the user names another: pxpl5 in $XDG_STATE_HOME, by
/// default ~/.local/state. Without a home folder: "run" in the current folder.
/// Source: XDG Base Directory Specification 0.8.
std::filesystem::path default_run_base();

/// Returns the absolute path of the system's folder for temporary files. Throws RequestError
/// (failed) that names the folder, the reason and TMPDIR.
std::filesystem::path temporary_parent();

/// Names of the temporary folders of `info` and of a class.
inline constexpr const char* info_folder = "pxpl5-info";
inline constexpr const char* class_folder = "pxpl5-class";

/// Removes the temporary folders of these names that killed programs of this user have left.
void remove_stale_temporary_folders();

/// A new folder for the owner alone; removed with its contents. If the program is killed, the next
/// start removes it.
class TemporaryFolder {
  public:
    /// `name` begins the folder's name. Throws RequestError (failed).
    explicit TemporaryFolder(const std::string& name);
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    const std::filesystem::path& path() const { return folder_.path(); }

  private:
    LockedFolder folder_;
};

}  // namespace pxpl5::host
