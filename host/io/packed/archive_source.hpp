// An archive, read file by file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

namespace pxpl5::host::io {

struct PackedEntry {
    std::string name;              ///< The stored one: it may lead anywhere, and be there twice.
    std::uint64_t size_bytes = 0;  ///< The stated size, if it can be that.
    bool is_folder = false;        ///< Without data of its own.
    bool is_link = false;          ///< A link to another file, unless it has the bytes of one.
    bool has_password = false;
};

/// The reason why one file cannot be unpacked, though others may be.
struct UnreadableEntry : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Memory that a library could not get is std::bad_alloc in all of its functions.
class ArchiveSource {
  public:
    virtual ~ArchiveSource() = default;

    /// Goes to the next file, folder or link. None after the last.
    /// Throws ImportError: the archive is damaged or cut, or is not one archive.
    virtual std::optional<PackedEntry> next() = 0;

    /// Reads data of the present file. Returns how many bytes came, 0 at the end, after which its
    /// checksum, if there is one, has been compared.
    /// Throws UnreadableEntry, or ImportError as next().
    virtual std::size_t read(std::span<char> out) = 0;
};

/// Opens a ZIP archive. Each entry of its directory is a file, unless it has no data and a name
/// with / at its end: type bits, which no checksum protects, are not asked.
/// Throws ImportError.
std::unique_ptr<ArchiveSource> open_zip(const std::filesystem::path& path);

/// Opens a tar archive, without compression or with gzip, bzip2, xz or zstd. next() refuses an
/// archive that does not end as tar archives do, or goes on after its end.
///
/// most_bytes  Of the archive without its compression.
/// Throws      ImportError.
std::unique_ptr<ArchiveSource> open_tar(const std::filesystem::path& path,
                                        std::uint64_t most_bytes);

}  // namespace pxpl5::host::io
