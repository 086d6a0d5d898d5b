// Slices as pictures: a TIFF of many pages, or a folder of numbered PNG or TIFF files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/io/values/import_request.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t max_pages = 4096;

/// Whether the suffix of `path` is that of a picture that is read.
bool is_picture(const std::filesystem::path& path);

/// Puts "s2" before "s10": runs of digits compare as numbers.
bool is_naturally_before(const std::string& a, const std::string& b);

/// Reads pictures of one size and type as slices, in this order; a file may hold several pages.
///
/// source   File or folder, for error texts.
/// Throws   ImportError: no spacing asked for, color, pictures that differ, a broken file.
Volume read_pictures(const std::string& source, const std::vector<std::filesystem::path>& files,
                     const ImportRequest& request);

}  // namespace pxpl5::host::io
