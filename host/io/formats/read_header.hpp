// The header of a volume file, in any of the formats that store values behind a header.
#pragma once

#include <filesystem>
#include <string>

#include "host/io/formats/stored_header.hpp"

namespace pxpl5::host::io {

/// format  Neither dicom nor pictures.
/// Throws  ImportError naming the field and its value.
StoredHeader read_stored_header(const std::filesystem::path& path, Format format,
                                const ImportRequest& request);

/// Throws ImportError if a later volume than the first is asked for: `source` has one.
void refuse_frame(const std::string& source, const ImportRequest& request);

}  // namespace pxpl5::host::io
