// Gzip files and zlib streams for tests.
#pragma once

#include <zlib.h>

#include <filesystem>
#include <string>

#include "tests/file_bytes.hpp"

namespace pxpl5::test {

/// The bytes of a gzip file with these contents. Writes a file at `path`, and removes it.
///
/// mode  "wb", and 1 to 9 behind it for another level.
inline std::string gzipped_at(const std::string& path, const std::string& bytes,
                              const char* mode = "wb") {
    gzFile file = gzopen(path.c_str(), mode);
    gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(file);
    std::string packed = file_bytes(path);
    std::filesystem::remove(path);
    return packed;
}

/// A zlib stream of these contents.
inline std::string zipped(const std::string& bytes) {
    uLongf size = compressBound(bytes.size());
    std::string out(size, '\0');
    compress(reinterpret_cast<Bytef*>(out.data()), &size,
             reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    out.resize(size);
    return out;
}

}  // namespace pxpl5::test
