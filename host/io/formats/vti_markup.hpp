// The markup of a VTK XML file of image data (.vti), up to the values of its point array.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace pxpl5::host::io {

/// Attributes of a tag by name, as the file spells them.
using TagAttributes = std::map<std::string, std::string>;

struct VtiMarkup {
    TagAttributes file, image, piece, point_data, array, appended;
    bool has_array = false;
    std::uint64_t values_at = 0;  ///< The byte of the file behind the tag that values follow.
};

/// Reads the tags VTKFile, ImageData, Piece, PointData, DataArray and AppendedData with expat. Ends
/// at the values: behind the tag of the array, or of AppendedData. The array is the one that
/// PointData names as Scalars, else the first.
/// Throws ImportError if the file is no XML, has a document type, or is of another kind.
VtiMarkup read_vti_markup(const std::filesystem::path& path);

}  // namespace pxpl5::host::io
