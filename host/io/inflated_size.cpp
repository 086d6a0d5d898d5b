#include "host/io/inflated_size.hpp"

#include <zlib.h>

#include <array>
#include <fstream>
#include <new>
#include <vector>

#include "host/io/import.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 18;
constexpr int any_header_bits = 15 + 32;  // The largest window; zlib and gzip headers both.

class Inflater {
  public:
    Inflater() : out_(chunk_bytes) {
        if (inflateInit2(&stream_, any_header_bits) != Z_OK) {
            throw std::bad_alloc();
        }
    }
    ~Inflater() { inflateEnd(&stream_); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    /// Takes all of `in`. Returns false at the end of the stream or if it is broken.
    bool take(std::vector<unsigned char>& in, std::size_t size_bytes, std::uint64_t enough) {
        stream_.next_in = in.data();
        stream_.avail_in = static_cast<unsigned>(size_bytes);
        while (bytes_ < enough) {
            stream_.next_out = out_.data();
            stream_.avail_out = static_cast<unsigned>(out_.size());
            const int result = inflate(&stream_, Z_NO_FLUSH);
            bytes_ += out_.size() - stream_.avail_out;
            // A gzip file may be several streams one after the other.
            const bool next_stream =
                result == Z_STREAM_END && stream_.avail_in > 0 && inflateReset(&stream_) == Z_OK;
            if (result == Z_BUF_ERROR ||
                (result == Z_OK && stream_.avail_in == 0 && stream_.avail_out > 0)) {
                return true;  // Wants more input.
            }
            if (result != Z_OK && !next_stream) {
                return false;
            }
        }
        return false;
    }
    std::uint64_t bytes() const { return bytes_; }

  private:
    z_stream stream_{};
    std::vector<unsigned char> out_;
    std::uint64_t bytes_ = 0;
};

}  // namespace

std::uint64_t inflated_bytes(const std::filesystem::path& path, std::uint64_t offset_bytes,
                             std::uint64_t enough) {
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(offset_bytes));
    if (!file) {
        throw ImportError(path.string() + ": cannot be opened");
    }
    std::vector<unsigned char> in(chunk_bytes);
    Inflater inflater;
    bool goes_on = true;
    while (goes_on && file) {
        file.read(reinterpret_cast<char*>(in.data()), static_cast<std::streamsize>(in.size()));
        const auto got = static_cast<std::size_t>(file.gcount());
        goes_on = got > 0 && inflater.take(in, got, enough);
    }
    return inflater.bytes();
}

std::uint32_t stated_gzip_bytes(const std::filesystem::path& path) {
    std::array<unsigned char, 4> end{};
    std::ifstream file(path, std::ios::binary);
    file.seekg(-4, std::ios::end);
    file.read(reinterpret_cast<char*>(end.data()), 4);
    const std::uint32_t upper = static_cast<std::uint32_t>(end[3]) << 24U;
    return file ? upper | end[0] | (end[1] << 8U) | (end[2] << 16U) : 0;
}

}  // namespace pxpl5::host::io
