// The request of the io process to read a PPHIGS archive.
#pragma once

#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::host::io {

/// Reads an archive, and flattens it to triangles, spheres and lines where the pictures show them.
/// Returns ArchiveContent, unless the request fails; then IoDone.
std::vector<bus::Payload> read_archive_file(const bus::schema::ReadArchive& request);

}  // namespace pxpl5::host::io
