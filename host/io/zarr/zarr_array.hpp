// An array of Zarr 2: a folder with a description, .zarray, and a file for each chunk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/io/formats/data_file.hpp"
#include "ringbus/rules/slices_file.hpp"

namespace pxpl5::host::io {

/// How the bytes of a chunk are compressed.
enum class ZarrCodec : std::uint8_t { none, zlib, zstd, blosc };

/// The description, checked. Axes are in the file's order, the last one fastest if `is_c_order`.
struct ZarrArray {
    std::filesystem::path folder;
    std::filesystem::path anchor;  ///< All files lie in the folder of this one, or below.
    std::vector<std::uint64_t> shape, chunks;  ///< Values along each axis: of all, and of a chunk.
    Component component = Component::uint8;
    bool big_endian = false, is_c_order = true;
    ZarrCodec codec = ZarrCodec::none;
    std::string separator = ".";  ///< Between the numbers in the name of a chunk's file.
    std::vector<std::byte> fill;  ///< The value of chunks without a file, as stored.
    std::string fill_text;        ///< The same for people.

    std::uint64_t chunk_bytes() const;
};

/// Reads a JSON object of at most 4 MiB and 32 levels.
/// anchor, allowed  As DataFile(): where links may lead.
/// Throws           ImportError.
nlohmann::json read_json(const std::filesystem::path& path, const std::filesystem::path& anchor,
                         const AllowedFolders& allowed);

/// Reads the description in `folder`. anchor, allowed: as read_json().
/// Throws ImportError naming the field of .zarray and its value.
ZarrArray read_zarr_array(const std::filesystem::path& folder, const std::filesystem::path& anchor,
                          const AllowedFolders& allowed);

/// The file of a chunk. index: its number along each axis.
std::filesystem::path chunk_file(const ZarrArray& array, std::span<const std::uint64_t> index);

/// Whether a chunk has a file. Throws ImportError if that cannot be seen.
bool has_chunk_file(const ZarrArray& array, std::span<const std::uint64_t> index);

/// The values of a chunk as stored, decompressed into `out`, which has chunk_bytes(). They
/// are the array's fill value if the chunk has no file.
///
/// index    Number of the chunk along each axis.
/// allowed  Folders to which links may lead, beside the image's own.
/// Throws   ImportError naming the file.
void read_chunk(const ZarrArray& array, std::span<const std::uint64_t> index,
                const AllowedFolders& allowed, std::span<std::byte> out);

}  // namespace pxpl5::host::io
