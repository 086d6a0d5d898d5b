// A request for a volume, its limits, and the error of a failed import.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "generated/vocabulary.hpp"
#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host::io {

/// Thrown for input that cannot be imported. `what` names the file, the field and both values.
struct ImportError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// How the values of a file without a header lie: x fastest.
struct RawLayout {
    std::array<std::uint32_t, 3> dims{};  ///< Voxels along x, y, z.
    std::string type;                     ///< A name of component_name().
    bool big_endian = false;
    std::uint64_t offset_bytes = 0;  ///< Before the first value.
};

/// A request to read a volume; only `path` is required.
struct ImportRequest {
    std::string path;    ///< A file, a folder, or phantom:NAME.
    std::string series;  ///< DICOM: place in the list from 1, UID or SeriesNumber.
    std::optional<glm::dvec3> spacing_mm;  ///< For files that state none: pictures, raw files.
    /// Sides of the patient to which x, y, z point ("RAI"), and the place of the first voxel, LPS:
    /// for files that state no orientation.
    std::string orientation;
    std::optional<glm::dvec3> origin_mm;
    std::optional<RawLayout> raw;
    /// First voxel and number of voxels kept; both or none.
    std::optional<std::array<std::uint32_t, 3>> crop_first, crop_size;
    std::optional<std::array<std::uint32_t, 3>> resample_size;  ///< Voxels afterwards.
    std::optional<glm::dvec3> resample_spacing_mm;              ///< Or their distance.
    /// Folders in which the data files of headers may lie, beside the header's own.
    std::vector<std::string> allowed{};
    double smooth_mm = 0;  ///< Standard deviation of a Gaussian; 0 for none.
    ReadBy read = ReadBy::automatic;
    /// automatic: GPs read values of more bytes.
    std::uint64_t host_bytes = max_volume_bytes;
    std::uint64_t reduced_bytes = std::uint64_t{64} << 20;  ///< Most bytes of the reduced copy.
    std::uint32_t frame = 0;  ///< Volume of a time series, from 1; 0: the file has one volume.
};

}  // namespace pxpl5::host::io
