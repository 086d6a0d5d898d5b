// How many bytes a zlib or gzip stream really holds: some decoders take cut streams in silence.
#pragma once

#include <cstdint>
#include <filesystem>

namespace pxpl5::host::io {

/// Decompresses `path` from `offset_bytes` on until `enough` bytes are out, the stream ends, or it
/// is broken.
/// Returns the bytes that came out; at most one buffer more than `enough`.
/// Throws ImportError if `path` cannot be opened.
std::uint64_t inflated_bytes(const std::filesystem::path& path, std::uint64_t offset_bytes,
                             std::uint64_t enough);

/// The size that a gzip file states in its last four bytes, modulo 2^32; 0 if it has none.
std::uint32_t stated_gzip_bytes(const std::filesystem::path& path);

}  // namespace pxpl5::host::io
