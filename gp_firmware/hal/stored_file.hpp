// A file on a file system that all computers share, open for reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::gp {

/// Thrown if a file cannot be read, or is not the stated one. what() names the file, both values
/// and the remedy, but not the GP.
struct StoredFileError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class StoredFile {
  public:
    /// Opens a regular file and compares its facts with the stated ones. Throws StoredFileError.
    StoredFile(const std::string& path, const FileFacts& stated);
    ~StoredFile();
    StoredFile(const StoredFile&) = delete;
    StoredFile& operator=(const StoredFile&) = delete;

    /// Fills `out` with the bytes from `offset_bytes` on. Throws StoredFileError if the file ends
    /// before.
    void read(std::uint64_t offset_bytes, std::span<std::byte> out) const;
    /// Compares the facts again. Throws StoredFileError.
    void check() const;

  private:
    std::string path_;
    FileFacts stated_;
    int file_ = -1;
};

/// The name of this computer; "an unknown computer" if it has none.
std::string computer_name();

}  // namespace pxpl5::gp
