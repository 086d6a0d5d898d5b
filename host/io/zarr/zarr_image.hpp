// An image of OME-Zarr (NGFF 0.1 to 0.4): levels of resolution, each an array of Zarr 2.
#pragma once

#include <filesystem>

#include "host/io/values/import_request.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// Whether the folder is an image, or a level of one.
bool is_zarr(const std::filesystem::path& path);

/// The folder of the image: `path` or, if this is a level, the folder around it.
std::filesystem::path zarr_root(const std::filesystem::path& path);

/// Reads the level that `path` is; of an image, the finest level that fits the limits.
/// Throws ImportError.
Volume read_zarr(const std::filesystem::path& path, const ImportRequest& request);

}  // namespace pxpl5::host::io
