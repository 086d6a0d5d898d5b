// Values that the GPs read, too: their type, range, digest and a reduced copy.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "host/io/formats/data_file.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host::io {

/// How the files of a volume are opened.
struct ScanPlace {
    std::string source;            ///< For error texts.
    std::filesystem::path header;  ///< It names the files. Empty if each file has its own header.
    AllowedFolders allowed;
    std::uint64_t reduced_bytes;  ///< Most bytes of the reduced copy.
};

/// Reads the values of `volume.stored` once, and once more if voxels are not the stored values.
/// Sets type, range, digest, reduction and the copy, and the facts of the files. If all values fit
/// into the copy, `values` has them.
/// volume  Has its size, and files that may have no facts yet.
/// Throws  ImportError, also if a file changes meanwhile.
void scan_values(const ScanPlace& place, Volume& volume);

}  // namespace pxpl5::host::io
