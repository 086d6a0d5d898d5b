// The first bytes of a file, and the archives that they belong to.
#pragma once

#include <filesystem>
#include <string>

namespace pxpl5::host::io {

/// The first 262 bytes: a tar archive has its mark at their end. Zeros where the file has fewer, or
/// cannot be read.
std::string first_bytes(const std::filesystem::path& path);

/// Whether these are the first bytes of a POSIX or GNU tar archive. Older ones have no mark.
bool begins_as_tar(const std::string& first);

/// Whether these are the first bytes of a ZIP archive, also of an empty one. A tar archive, which
/// begins with a name, is none.
bool begins_as_zip(const std::string& first);

}  // namespace pxpl5::host::io
