// The files that the browser's commands may read and write.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/base/command_descriptor.hpp"

namespace pxpl5::host::serve {

/// Confines the paths of commands to folders. Whoever has the driver's address may steer the
/// viewer, and shall not read or write every file of the user. A hidden file or folder below an
/// allowed folder is not allowed: it holds keys, settings or commands that a program runs. It is
/// allowed if it was named itself.
class FileAccess {
  public:
    /// downloads  Commands write any file here.
    /// others     Commands read here, and write files that are new and not hidden.
    FileAccess(std::filesystem::path downloads, std::vector<std::filesystem::path> others);

    /// Adds the folder of a volume that the user has named: the folder itself for a series.
    void allow_volume(const std::string& source);

    /// Throws RequestError (usage) that names the path and the remedy if a word of the command is a
    /// file that it may not read or write, or if it would write such a file beside an output. Links
    /// count as what they lead to.
    void check(const CommandDescriptor& command, const Arguments& arguments) const;

  private:
    enum class Place { allowed, hidden, outside };
    Place place_of(const std::filesystem::path& real) const;
    void check_read(const CommandDescriptor& command, const std::string& path) const;
    void check_write(const CommandDescriptor& command, const std::filesystem::path& file) const;

    std::filesystem::path downloads_;
    std::vector<std::filesystem::path> folders_;  ///< All, their links followed.
};

}  // namespace pxpl5::host::serve
