// Volumes in: decodes a file or a DICOM folder into a plain Volume. All of ITK is behind this.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "host/volume.hpp"

namespace pxpl5::host::io {

inline constexpr int min_dim = 2;     ///< Voxels along an axis: fewer hold no cell.
inline constexpr int max_dim = 4096;  ///< Voxels along an axis.
inline constexpr std::uint64_t max_volume_bytes = std::uint64_t{8} << 30;

/// Thrown for input that cannot be imported. `what` names the file, the field and both values.
struct ImportError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Decodes NRRD, MetaImage, NIfTI-1, Analyze 7.5, VTK legacy or DICOM.
///
/// path     A file, or the folder of a DICOM series.
/// Returns  the volume: uint8, int16, uint16 and float32 as stored, other types converted
///          without loss where possible. minimum and maximum are over the finite values. Every
///          conversion and assumption is in `notes`. name is the file's name without suffix.
/// Throws   ImportError.
Volume import_volume(const std::string& path);

}  // namespace pxpl5::host::io
