#include "host/io/formats/header_bytes.hpp"

#include <fmt/format.h>

#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

std::string HeaderBytes::text(std::size_t offset, std::size_t count) const {
    const char* begin = reinterpret_cast<const char*>(bytes.data()) + offset;
    return {begin, strnlen(begin, count)};
}

HeaderBytes read_header_bytes(const std::filesystem::path& path, std::size_t least,
                              std::size_t most) {
    HeaderBytes header;
    header.bytes.resize(most);
    header.encoding = is_gzip(path) ? Encoding::gzip : Encoding::raw;
    ByteSource source(path, header.encoding, 0);
    header.size_bytes = source.read(header.bytes);
    header.damage = source.damage();
    check_header_size(path.string(), header, least);
    return header;
}

void check_header_size(const std::string& file, const HeaderBytes& header, std::size_t least) {
    if (header.size_bytes < least) {
        throw ImportError(fmt::format("{}: its header needs {} bytes, {} could be read{}", file,
                                      least, header.size_bytes, header.damage));
    }
}

}  // namespace pxpl5::host::io
