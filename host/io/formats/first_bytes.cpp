#include "host/io/formats/first_bytes.hpp"

#include <fstream>
#include <string_view>

namespace pxpl5::host::io {

namespace {

constexpr std::size_t tar_mark_at = 257;
constexpr std::string_view tar_mark = "ustar";

}  // namespace

std::string first_bytes(const std::filesystem::path& path) {
    std::string first(tar_mark_at + tar_mark.size(), '\0');
    std::ifstream(path, std::ios::binary)
        .read(first.data(), static_cast<std::streamsize>(first.size()));
    return first;
}

bool begins_as_tar(const std::string& first) {
    return first.compare(tar_mark_at, tar_mark.size(), tar_mark) == 0;
}

bool begins_as_zip(const std::string& first) {
    return (first.starts_with("PK\3\4") || first.starts_with("PK\5\6")) && !begins_as_tar(first);
}

}  // namespace pxpl5::host::io
