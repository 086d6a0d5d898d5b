// The bytes of a file, decompressed as they are asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace pxpl5::host::io {

/// How values lie in a file. `gzip` takes zlib streams too; gzip_base64 is gzip within base64.
enum class Encoding : std::uint8_t { raw, gzip, bzip2, ascii, hex, base64, gzip_base64 };

constexpr bool is_gzip(Encoding encoding) {
    return encoding == Encoding::gzip || encoding == Encoding::gzip_base64;
}

constexpr bool is_compressed(Encoding encoding) {
    return is_gzip(encoding) || encoding == Encoding::bzip2;
}

constexpr bool is_base64(Encoding encoding) {
    return encoding == Encoding::base64 || encoding == Encoding::gzip_base64;
}

/// Characters of base64 for so many bytes, padding included.
constexpr std::uint64_t base64_chars(std::uint64_t bytes) {
    return (bytes + 2) / 3 * 4;
}

class ByteSource {
  public:
    /// Opens `path` at `offset_bytes`. `ascii` gives the file's own bytes.
    /// most_bytes   Bytes of the file that are read at most. No limit for raw bytes and text.
    /// Throws       ImportError if it cannot be opened.
    ByteSource(const std::filesystem::path& path, Encoding encoding, std::uint64_t offset_bytes,
               std::uint64_t most_bytes = std::numeric_limits<std::uint64_t>::max());
    ~ByteSource();
    ByteSource(const ByteSource&) = delete;
    ByteSource& operator=(const ByteSource&) = delete;

    /// Fills `out`. Returns how many bytes came: fewer at the end, or where the stream is broken.
    std::size_t read(std::span<std::byte> out);

    /// Passes over `count` bytes of what read() would give. Returns how many there were.
    std::uint64_t skip(std::uint64_t count);

    /// Whether the end that read() came to was no end but damage: a wrong code or checksum.
    bool is_damaged() const { return damaged_; }

    /// Whether the file ended within a gzip stream, before its checksum.
    bool is_cut() const { return ended_ && is_gzip(encoding_) && !between_streams_; }

    /// The end of an error's text: "; its compressed data are broken at byte 812 of the file", or
    /// cut. Empty if the data are neither.
    std::string damage() const;

    /// Bytes of the file after the last gzip stream, once read() has come to its end.
    std::uint64_t bytes_after_end() const;

  private:
    struct Inflater;
    struct Bunzipper;

    std::size_t read_file();
    std::size_t read_gzip(std::span<std::byte> out);
    std::size_t read_bzip2(std::span<std::byte> out);
    std::size_t read_hex(std::span<std::byte> out);
    std::size_t read_buffered(std::span<std::byte> out);
    void decode_base64();

    std::ifstream file_;
    Encoding encoding_;
    std::vector<char> in_;  ///< A chunk of the file.
    std::size_t in_at_ = 0, in_end_ = 0;
    std::uint64_t size_bytes_ = 0;       ///< Size of the file.
    std::uint64_t unread_bytes_ = 0;     ///< Bytes of the file.
    std::uint64_t position_ = 0;         ///< The byte of the file behind in_.
    std::uint64_t bytes_after_end_ = 0;  ///< After the last stream that was whole.
    bool ended_ = false;                 ///< Nothing more comes.
    bool damaged_ = false;
    bool between_streams_ = false;  ///< The next bytes may be no stream.
    unsigned bits_ = 0;             ///< Digits of base64 that are no byte yet.
    int bit_count_ = 0;
    bool base64_ended_ = false;
    std::unique_ptr<Inflater> inflater_;
    std::unique_ptr<Bunzipper> bunzipper_;
};

/// Whether the file begins as gzip streams do, whatever its suffix says.
bool is_gzip(const std::filesystem::path& path);

}  // namespace pxpl5::host::io
