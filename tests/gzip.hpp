// Gzip files for tests.
#pragma once

#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace pxpl5::test {

/// The bytes of a gzip file with these contents. Writes a file at `path`, and removes it.
///
/// mode  "wb", and 1 to 9 behind it for another level.
inline std::string gzipped_at(const std::string& path, const std::string& bytes,
                              const char* mode = "wb") {
    gzFile file = gzopen(path.c_str(), mode);
    gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(file);
    std::ifstream stream(path, std::ios::binary);
    std::string packed{std::istreambuf_iterator<char>(stream), {}};
    std::filesystem::remove(path);
    return packed;
}

}  // namespace pxpl5::test
