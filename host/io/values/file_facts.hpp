// Facts of a file, which differ after a change of the file.
#pragma once

#include <sys/stat.h>

#include <filesystem>

#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host::io {

FileFacts facts_of(const struct stat& file);

/// Throws ImportError if there is no regular file of this name.
FileFacts facts_of(const std::filesystem::path& file);

}  // namespace pxpl5::host::io
