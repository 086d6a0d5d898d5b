#include "host/serve/director/slice_packing.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include "host/base/error.hpp"
#include "ringbus/rules/byte_planes.hpp"

namespace pxpl5::host::serve {

std::vector<std::byte> pack_slice(std::span<const std::byte> bytes, std::size_t count,
                                  std::size_t value_bytes) {
    std::vector<std::byte> plain(bytes.begin(), bytes.end());
    const std::size_t value_part = count * value_bytes;
    split_into_planes(bytes.first(value_part), value_bytes, std::span(plain).first(value_part));
    uLongf size = compressBound(static_cast<uLong>(plain.size()));
    std::vector<std::byte> packed(size);
    if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                  reinterpret_cast<const Bytef*>(plain.data()), static_cast<uLong>(plain.size()),
                  Z_BEST_SPEED) != Z_OK) {
        throw RequestError(ExitCode::failed, fmt::format("ask: no memory to compress a slice of {} "
                                                         "bytes; ask for it without 'packed'",
                                                         plain.size()));
    }
    packed.resize(size);
    return packed;
}

}  // namespace pxpl5::host::serve
