// Files that a confined process may still open.
#pragma once

#include <filesystem>
#include <vector>

namespace pxpl5::host::io {

/// Paths are opened once, when the rules come into force: links of theirs are followed. A path that
/// does not exist is left out. Folders stand for everything below them, links inside excepted.
struct FileRules {
    std::vector<std::filesystem::path> readable;  ///< Files and folders.
    std::vector<std::filesystem::path> listed;    ///< Folders whose names may be read, no file.
    std::vector<std::filesystem::path> writable;  ///< Folders: files are made, renamed, removed.
};

/// Lets all threads of this process open only the files of `rules`, and send signals only to this
/// process, by Landlock. Cannot be undone. Open descriptors stay as they are.
///
/// Returns  false if the kernel has no Landlock.
/// Throws   std::runtime_error if the kernel refuses the rules.
bool restrict_files(const FileRules& rules);

}  // namespace pxpl5::host::io
