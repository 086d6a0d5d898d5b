// The files and the room that a request needs, known before it is served.
#pragma once

#include <string>
#include <vector>

#include "host/io/sandbox/sandbox.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host::io {

/// Returns the needs of an ImportVolume, ReadMesh, ReadArchive, ExportPicture or ExportMesh.
///
/// allowed  Folders in which headers may name data files, beside their own.
Needs needs_of(const bus::Message& request, const std::vector<std::string>& allowed);

/// Returns the needs of a look through a file or a folder of DICOM files.
Needs needs_of_survey(const std::string& path, const std::vector<std::string>& allowed);

}  // namespace pxpl5::host::io
