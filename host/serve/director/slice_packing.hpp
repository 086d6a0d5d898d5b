// Slices for a slow link.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace pxpl5::host::serve {

/// The bytes of an answer to `ask slice`, smaller and without loss. The page takes them apart again
/// (page/slices/slice_packing.js).
///
/// The first `count` values become differences to the value before, as unsigned numbers, and then
/// planes: the lowest bytes of all, then the next ones. All of it is compressed by zlib (RFC 1950).
///
/// bytes        At least count * value_bytes.
/// value_bytes  1, 2 or 4; little endian.
/// Throws       RequestError (failed) if zlib has no memory.
std::vector<std::byte> pack_slice(std::span<const std::byte> bytes, std::size_t count,
                                  std::size_t value_bytes);

}  // namespace pxpl5::host::serve
