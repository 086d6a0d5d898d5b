// The bytes of a tar archive, without its compression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pxpl5::host::io {

enum class Compression : std::uint8_t { none, gzip, bzip2, xz, zstd };

/// Reads a file once, from its first byte to its last, so that the checksums behind the data are
/// compared, too. Exactly one layer of compression is taken away.
class TarBytes {
  public:
    /// most_bytes  Of the bytes that are not compressed.
    /// Throws      ImportError naming the file if it cannot be opened.
    TarBytes(const std::filesystem::path& path, Compression compression, std::uint64_t most_bytes);
    ~TarBytes();
    TarBytes(const TarBytes&) = delete;
    TarBytes& operator=(const TarBytes&) = delete;

    /// The next bytes, until the next call; none at the end.
    /// Throws ImportError naming the file: its data are damaged or cut, or are more than
    /// most_bytes.
    std::span<const std::byte> next();

    /// How many bytes next() has given.
    std::uint64_t count() const { return count_; }

    /// How many bytes next() has given without the zeros after the last other byte.
    std::uint64_t count_without_zeros() const { return count_without_zeros_; }

  private:
    struct Source;
    struct Stored;
    struct Filtered;

    std::string file_;
    std::uint64_t most_bytes_, count_ = 0, count_without_zeros_ = 0;
    std::vector<std::byte> block_;
    std::unique_ptr<Source> source_;
};

}  // namespace pxpl5::host::io
