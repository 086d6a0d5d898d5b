// The files that the browser's commands may read and write.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
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
    /// own        Likewise, but roots() leaves these folders out: they belong to the program.
    FileAccess(std::filesystem::path downloads, std::vector<std::filesystem::path> others,
               std::vector<std::filesystem::path> own = {});

    /// Adds the folder of a volume that the user has named: the folder itself for a series.
    void allow_volume(const std::string& source);

    /// Throws RequestError (usage) that names the path and the remedy if a word of the command is a
    /// file that it may not read or write, or if it would write such a file beside an output. Links
    /// count as what they lead to.
    void check(const CommandDescriptor& command, const Arguments& arguments) const;

    /// Throws as check() does unless the browser may read the file or folder.
    ///
    /// who  The command or question, for the error.
    void check_read(std::string_view who, const std::string& path) const;

    /// Whether the browser may read the file or folder. Links count as what they lead to.
    bool may_read(const std::filesystem::path& path) const;

    /// The folders that the user has allowed, their links followed, without folders that lie in
    /// another of them.
    std::vector<std::filesystem::path> roots() const;

  private:
    enum class Place { allowed, hidden, outside };
    Place place_of(const std::filesystem::path& real) const;
    void check_write(const CommandDescriptor& command, const std::filesystem::path& file) const;

    std::filesystem::path downloads_;
    std::vector<std::filesystem::path> own_;
    std::vector<std::filesystem::path> folders_;  ///< All, their links followed.
};

}  // namespace pxpl5::host::serve
