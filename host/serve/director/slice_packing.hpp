// Slices for a slow link.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace pxpl5::host::serve {

/// The bytes of an answer to `ask slice`, smaller and without loss. The page takes them apart again
/// (page/slices/slice_packing.js).
///
/// The first `count` values become planes of bytes (ringbus/rules/byte_planes.hpp). All of it is
/// compressed by zlib (RFC 1950), which browsers can undo.
///
/// bytes        At least count * value_bytes.
/// value_bytes  1, 2 or 4; little endian.
/// Throws       RequestError (failed) if zlib has no memory.
std::vector<std::byte> pack_slice(std::span<const std::byte> bytes, std::size_t count,
                                  std::size_t value_bytes);

}  // namespace pxpl5::host::serve
