// The parts that the users of libarchive share.
#pragma once

#include <archive.h>

#include <cerrno>
#include <cstddef>
#include <memory>
#include <new>
#include <string>

#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

inline constexpr std::size_t archive_block_bytes = 1 << 16;

struct FreeArchive {
    void operator()(archive* reader) const { archive_read_free(reader); }
};
using ArchiveReader = std::unique_ptr<archive, FreeArchive>;

/// Throws std::bad_alloc.
inline ArchiveReader new_archive_reader() {
    ArchiveReader reader(archive_read_new());
    if (!reader) {
        throw std::bad_alloc();
    }
    return reader;
}

/// libarchive's last error, as an error may show it. Throws std::bad_alloc if it is that.
inline std::string reason_of(archive* reader) {
    if (archive_errno(reader) == ENOMEM) {
        throw std::bad_alloc();
    }
    const char* const reason = archive_error_string(reader);
    return reason == nullptr ? "no reason is given" : shown(reason);
}

}  // namespace pxpl5::host::io
