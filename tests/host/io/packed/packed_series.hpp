// Archives of a small DICOM series, and what the import says of them.
#pragma once

#include <array>
#include <string>

#include "host/io/import.hpp"
#include "tests/host/io/packed/packed.hpp"
#include "tests/host/io/volume_writers.hpp"

namespace pxpl5::test {

struct ArchiveKind {
    const char* name;
    int format, compression = ARCHIVE_FILTER_NONE;
    const char* options = nullptr;
};
inline constexpr std::array kinds = {
    ArchiveKind{"scan.zip", ARCHIVE_FORMAT_ZIP},
    ArchiveKind{"scan.ZIP", ARCHIVE_FORMAT_ZIP, ARCHIVE_FILTER_NONE, "zip:compression=store"},
    ArchiveKind{"scan.tar", ARCHIVE_FORMAT_TAR_USTAR},
    ArchiveKind{"scan.tar", ARCHIVE_FORMAT_TAR_PAX_INTERCHANGE},
    ArchiveKind{"scan.tar", ARCHIVE_FORMAT_TAR_GNUTAR},
    ArchiveKind{"scan.tgz", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_GZIP},
    ArchiveKind{"scan.tar.gz", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_GZIP},
    ArchiveKind{"scan.tar.bz2", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_BZIP2},
    ArchiveKind{"scan.tar.xz", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_XZ},
    ArchiveKind{"scan.tar.zst", ARCHIVE_FORMAT_TAR_USTAR, ARCHIVE_FILTER_ZSTD},
    ArchiveKind{"scan", ARCHIVE_FORMAT_ZIP},  // By their first bytes.
    ArchiveKind{"scan", ARCHIVE_FORMAT_TAR_USTAR},
};

inline Grid grid() {
    Grid small{{6, 5, 4}, glm::dmat4(1.0), ramp<std::int16_t>(120)};
    small.affine[3] = {10, -20, 30, 1};
    return small;
}

/// Slices whose names say nothing about their order, as IM1 to IM4.
inline NamedBytes series(const std::string& uid = "1.2.3") {
    NamedBytes files;
    for (const int z : {2, 0, 3, 1}) {
        DicomSet set = dicom_slice(grid(), z);
        set.text(0x20, 0xe, "UI", uid);
        files.emplace_back("IM" + std::to_string(files.size() + 1), set.file());
    }
    return files;
}

inline host::Volume read(const std::string& path, ReadBy by = ReadBy::automatic) {
    host::io::ImportRequest request;
    request.path = path;
    request.read = by;
    return host::io::import_volume(request);
}

inline std::string refusal(const std::string& path, ReadBy by = ReadBy::automatic) {
    try {
        read(path, by);
        return "";
    } catch (const host::io::ImportError& error) {
        return error.what();
    }
}

}  // namespace pxpl5::test
