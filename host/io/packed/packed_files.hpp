// The DICOM files in a ZIP or tar archive, unpacked into memory: nothing is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/io/dicom/dicom_input.hpp"
#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host::io {

/// Files, folders and links of an archive.
inline constexpr std::size_t max_packed_entries = 65'536;

struct PackedFiles {
    std::vector<DicomInput> dicom;        ///< By name; each is named "scan.zip/CT/IM7".
    std::vector<std::string> unreadable;  ///< "scan.zip/CT/IM8: is protected by a password .."
    std::size_t others = 0;               ///< Files that do not begin as DICOM files.
    std::size_t links = 0;                ///< Links, which are not followed.
    std::size_t repeated = 0;             ///< Files whose name a later one has, too.
};

/// Unpacks ZIP, and tar without compression or with gzip, bzip2, xz or zstd, whose checksums have
/// to be right. Archives in the archive are not opened. All files with one name are given: they may
/// be different slices.
///
/// most_bytes  Of all DICOM files together; all files may have twice as many. An archive of a few
/// KB
///             can unpack to petabytes.
/// Throws      ImportError naming the archive and the reason: it is no archive, it is damaged or
///             cut, or it has too many files or bytes, or too long a name.
PackedFiles unpack(const std::filesystem::path& archive,
                   std::uint64_t most_bytes = max_volume_bytes);

}  // namespace pxpl5::host::io
