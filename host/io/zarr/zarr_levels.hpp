// The metadata of an OME-Zarr image: its axes and its levels of resolution.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/io/zarr/zarr_array.hpp"

namespace pxpl5::host::io {

/// An image's metadata: the first of its multiscales.
struct ZarrImage {
    std::filesystem::path root;
    nlohmann::json scales;  ///< The first entry of "multiscales".

    /// The file with the metadata, for error texts.
    std::string file() const { return (root / ".zattrs").string(); }
};

/// An axis of the arrays.
struct ZarrAxis {
    std::string name;  ///< "t", "c", "z", "y" or "x".
    double unit = 0;   ///< In millimeters, or milliseconds of time; 0: not stated.
};

/// A level: its array and where it lies.
struct ZarrLevel {
    ZarrArray array;
    std::vector<double> scale, shift;  ///< Along each axis, in its unit.
    std::vector<ZarrAxis> axes;
    bool has_scale = false;             ///< The image states the distances of voxels.
    std::size_t number = 0, count = 0;  ///< Place among the image's levels, from 1, of so many.

    std::array<std::uint64_t, 3> sizes() const;  ///< Voxels along x, y, z.
};

/// The image that a folder is; nothing if it is none. Throws ImportError for broken JSON.
std::optional<ZarrImage> zarr_image_at(const std::filesystem::path& folder);

/// The level that `path` is, or, if this is the image, the finest level that fits the limits.
/// allowed  Folders to which links may lead, beside the image's own.
/// Throws   ImportError naming the field and its value, or the size of the coarsest level.
ZarrLevel zarr_level_for(const ZarrImage& image, const std::filesystem::path& path,
                         const AllowedFolders& allowed);

}  // namespace pxpl5::host::io
