// A folder of DICOM slices becomes one volume: which slices, in which order, how far apart.
#pragma once

#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "host/io/decoded.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t max_series_files = 20'000;

/// One file's header.
struct DicomSlice {
    std::filesystem::path path;
    std::string series;  ///< Series instance UID; may be empty.
    int columns = 0, rows = 0, frames = 1;
    glm::dvec3 x_step_mm{0}, y_step_mm{0};  ///< One column and one row further, LPS.
    glm::dvec3 origin_mm{0};                ///< Centre of the first voxel, LPS.
    bool spacing_stated = true, position_stated = true;
};

using ReadDicomHeader = std::function<std::optional<DicomSlice>(const std::filesystem::path&)>;
using DecodeSlice = std::function<Decoded(const std::filesystem::path&)>;

/// Puts the slices of the folder's largest series in order along their normal. The z step comes
/// from the slices' positions alone: thickness is not distance, and a tilted gantry shears.
/// Notes what was left out, gaps, repeated positions and missing spacing.
///
/// Throws   ImportError if there is no series or its slices state no positions.
Decoded assemble_series(const std::filesystem::path& folder, const ReadDicomHeader& read_header,
                        const DecodeSlice& decode);

}  // namespace pxpl5::host::io
