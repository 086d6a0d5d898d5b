// The bytes of a binary header, read as numbers of either byte order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "host/io/formats/byte_source.hpp"

namespace pxpl5::host::io {

struct HeaderBytes {
    std::vector<std::byte> bytes;  ///< Zeros behind the end of the file.
    std::size_t size_bytes = 0;    ///< Bytes that could be read.
    bool big_endian = false;
    Encoding encoding = Encoding::raw;  ///< How the whole file is stored: raw or gzip.
    std::string damage;                 ///< See ByteSource::damage().

    /// The number at a byte. It must lie within `bytes`.
    template <typename T>
    T at(std::size_t offset) const {
        std::array<std::byte, sizeof(T)> raw{};
        std::memcpy(raw.data(), bytes.data() + offset, sizeof(T));
        if (big_endian) {
            std::reverse(raw.begin(), raw.end());
        }
        return std::bit_cast<T>(raw);
    }

    /// Numbers of one type, one after the other.
    template <typename T, std::size_t count, typename To>
    void copy(std::size_t offset, std::array<To, count>& to) const {
        for (std::size_t i = 0; i < count; ++i) {
            to[i] = static_cast<To>(at<T>(offset + i * sizeof(T)));
        }
    }

    /// At most `count` characters, up to the first zero.
    std::string text(std::size_t offset, std::size_t count) const;
};

/// Reads the first bytes of a file, which may be compressed by gzip. The byte order is little
/// endian until the caller sets another.
/// least   Throws ImportError if the file has fewer bytes.
/// most    Bytes of HeaderBytes::bytes.
HeaderBytes read_header_bytes(const std::filesystem::path& path, std::size_t least,
                              std::size_t most);

/// Throws ImportError if fewer bytes than `least` could be read.
void check_header_size(const std::string& file, const HeaderBytes& header, std::size_t least);

}  // namespace pxpl5::host::io
