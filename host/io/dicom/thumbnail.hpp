// A small gray picture of one DICOM slice.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "host/io/dicom/dicom_series.hpp"

namespace pxpl5::host::io {

inline constexpr int thumbnail_side = 72;  ///< Pixels of the longer side.

struct Thumbnail {
    int width = 0, height = 0;
    std::vector<std::uint8_t> pixels;  ///< width * height, rows from the top.
};

/// The slice in the middle along the normal of its series, or in the middle of the list if the
/// slices cannot be ordered. `series` must not be empty (asserted).
DicomSlice middle_of(const std::vector<DicomSlice>& series);

/// Decodes the slice and reduces it: a pixel is the mean of the voxels that it covers. Pixels of
/// millimeters that differ along rows and columns keep their shape.
///
/// window  Center and width, of rescaled values; else from the 1 % lowest to the 1 % highest.
/// Throws  ImportError.
Thumbnail thumbnail_of(const DicomSlice& slice, std::optional<std::pair<double, double>> window);

}  // namespace pxpl5::host::io
