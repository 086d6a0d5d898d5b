// A data file that a volume's header names.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host::io {

/// Folders outside of the header's own from which headers may name data files.
using AllowedFolders = std::vector<std::string>;

/// An open data file. A header may come from a stranger, so its data must lie in the header's
/// folder or below, links followed: a header that names /etc/passwd would show that file as voxels.
class DataFile {
  public:
    /// Opens `data`, which the file `header` names. `data` may be the header itself.
    /// Throws ImportError that names both files and the remedy.
    DataFile(const std::filesystem::path& header, const std::filesystem::path& data,
             const AllowedFolders& allowed);
    ~DataFile();
    DataFile(const DataFile&) = delete;
    DataFile& operator=(const DataFile&) = delete;

    /// A path that opens this very file, even if its name now belongs to another.
    std::filesystem::path path() const;
    std::uint64_t size_bytes() const { return facts_.size_bytes; }
    /// The facts when the file was opened.
    const FileFacts& facts() const { return facts_; }
    /// The facts now.
    FileFacts facts_now() const;

  private:
    int file_ = -1;
    FileFacts facts_;
};

}  // namespace pxpl5::host::io
