#include "host/serve/director/slice_packing.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "host/base/error.hpp"

namespace pxpl5::host::serve {

namespace {

/// Writes the planes of the differences of `count` values of type T to `planes`.
template <typename T>
void split(std::span<const std::byte> bytes, std::size_t count, std::span<std::byte> planes) {
    T before = 0;
    for (std::size_t k = 0; k < count; ++k) {
        T value = 0;
        std::memcpy(&value, bytes.data() + k * sizeof value, sizeof value);
        const auto difference = static_cast<T>(value - before);
        for (std::size_t plane = 0; plane < sizeof value; ++plane) {
            planes[plane * count + k] = static_cast<std::byte>(difference >> 8 * plane);
        }
        before = value;
    }
}

}  // namespace

std::vector<std::byte> pack_slice(std::span<const std::byte> bytes, std::size_t count,
                                  std::size_t value_bytes) {
    std::vector<std::byte> plain(bytes.begin(), bytes.end());
    const auto planes = std::span(plain).first(count * value_bytes);
    value_bytes == 1   ? split<std::uint8_t>(bytes, count, planes)
    : value_bytes == 2 ? split<std::uint16_t>(bytes, count, planes)
                       : split<std::uint32_t>(bytes, count, planes);
    uLongf size = compressBound(static_cast<uLong>(plain.size()));
    std::vector<std::byte> packed(size);
    if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                  reinterpret_cast<const Bytef*>(plain.data()), static_cast<uLong>(plain.size()),
                  Z_BEST_SPEED) != Z_OK) {
        throw RequestError(ExitCode::failed, "ask: no memory to compress the slice");
    }
    packed.resize(size);
    return packed;
}

}  // namespace pxpl5::host::serve
