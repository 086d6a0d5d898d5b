#include "host/io/formats/byte_source.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <limits>
#include <new>

#include "host/io/values/base64.hpp"
#include "host/io/values/import_request.hpp"

#if PXPL5_BZIP2
#include <bzlib.h>
#endif

namespace pxpl5::host::io {

namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 18;
constexpr int any_header_bits = 15 + 32;  // The largest window; zlib and gzip headers both.

unsigned narrow(std::size_t size) {
    return static_cast<unsigned>(std::min<std::size_t>(size, std::numeric_limits<int>::max()));
}

int hex_digit(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

}  // namespace

struct ByteSource::Inflater {
    z_stream stream{};
    Inflater() {
        if (inflateInit2(&stream, any_header_bits) != Z_OK) {
            throw std::bad_alloc();
        }
    }
    ~Inflater() { inflateEnd(&stream); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
};

#if PXPL5_BZIP2
struct ByteSource::Bunzipper {
    bz_stream stream{};
    Bunzipper() { begin(); }
    ~Bunzipper() { BZ2_bzDecompressEnd(&stream); }
    Bunzipper(const Bunzipper&) = delete;
    Bunzipper& operator=(const Bunzipper&) = delete;

    void begin() {
        if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) {
            throw std::bad_alloc();
        }
    }
};

std::size_t ByteSource::read_bzip2(std::span<std::byte> out) {
    if (in_at_ == in_end_ && read_file() == 0) {
        ended_ = true;
        return 0;
    }
    bz_stream& stream = bunzipper_->stream;
    const unsigned before = narrow(out.size());
    stream.next_in = in_.data() + in_at_;
    stream.avail_in = narrow(in_end_ - in_at_);
    stream.next_out = reinterpret_cast<char*>(out.data());
    stream.avail_out = before;
    const int result = BZ2_bzDecompress(&stream);
    in_at_ = in_end_ - stream.avail_in;
    const std::size_t got = before - stream.avail_out;
    if (result == BZ_STREAM_END) {
        BZ2_bzDecompressEnd(&stream);
        stream = {};
        bunzipper_->begin();
    } else if (result != BZ_OK) {
        ended_ = true;
        damaged_ = !between_streams_;
    }
    between_streams_ = result == BZ_STREAM_END;
    return got;
}
#else
struct ByteSource::Bunzipper {
    Bunzipper() {
        throw ImportError("this program was built without bzip2; build it with -DPXPL5_BZIP2=ON");
    }
};

std::size_t ByteSource::read_bzip2(std::span<std::byte> /*out*/) {
    return 0;  // Bunzipper() has thrown.
}
#endif

ByteSource::ByteSource(const std::filesystem::path& path, Encoding encoding,
                       std::uint64_t offset_bytes, std::uint64_t most_bytes)
    : file_(path, std::ios::binary), encoding_(encoding), in_(chunk_bytes) {
    file_.seekg(0, std::ios::end);
    size_bytes_ = static_cast<std::uint64_t>(std::max<std::streamoff>(file_.tellg(), 0));
    unread_bytes_ = std::min(size_bytes_ - std::min(size_bytes_, offset_bytes), most_bytes);
    file_.seekg(static_cast<std::streamoff>(offset_bytes));
    position_ = offset_bytes;
    if (!file_) {
        throw ImportError(path.string() + ": cannot be opened");
    }
    if (is_gzip(encoding)) {
        inflater_ = std::make_unique<Inflater>();
    } else if (encoding == Encoding::bzip2) {
        bunzipper_ = std::make_unique<Bunzipper>();
    }
}

ByteSource::~ByteSource() = default;

/// The next chunk of the file into in_, decoded if it is base64. Returns its size: 0 at the end.
std::size_t ByteSource::read_file() {
    do {
        const std::uint64_t wanted = std::min<std::uint64_t>(in_.size(), unread_bytes_);
        file_.read(in_.data(), static_cast<std::streamsize>(wanted));
        in_at_ = 0;
        in_end_ = static_cast<std::size_t>(file_.gcount());
        unread_bytes_ -= in_end_;
        position_ += in_end_;
        if (in_end_ == 0 || !is_base64(encoding_)) {
            return in_end_;
        }
        decode_base64();
    } while (in_end_ == 0 && !base64_ended_);
    return in_end_;
}

/// Puts the bytes of in_'s digits in place of them. White space may lie between; padding or another
/// character is the end.
void ByteSource::decode_base64() {
    std::size_t to = 0;
    for (std::size_t at = 0; at < in_end_ && !base64_ended_; ++at) {
        const char c = in_[at];
        const int digit = base64_digit(c);
        if (digit < 0) {
            base64_ended_ = std::isspace(static_cast<unsigned char>(c)) == 0;
            continue;
        }
        bits_ = bits_ << 6U | static_cast<unsigned>(digit);
        bit_count_ += 6;
        if (bit_count_ >= 8) {
            bit_count_ -= 8;
            in_[to++] = static_cast<char>(bits_ >> static_cast<unsigned>(bit_count_) & 0xFFU);
        }
    }
    in_end_ = to;
    unread_bytes_ = base64_ended_ ? 0 : unread_bytes_;
}

std::size_t ByteSource::read(std::span<std::byte> out) {
    if (encoding_ == Encoding::raw || encoding_ == Encoding::ascii) {
        file_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
        return static_cast<std::size_t>(file_.gcount());
    }
    std::size_t got = 0;
    while (got < out.size() && !ended_) {
        const std::span<std::byte> rest = out.subspan(got);
        got += is_gzip(encoding_)              ? read_gzip(rest)
               : encoding_ == Encoding::bzip2  ? read_bzip2(rest)
               : encoding_ == Encoding::base64 ? read_buffered(rest)
                                               : read_hex(rest);
    }
    return got;
}

std::size_t ByteSource::read_buffered(std::span<std::byte> out) {
    if (in_at_ == in_end_ && read_file() == 0) {
        ended_ = true;
        return 0;
    }
    const std::size_t got = std::min(out.size(), in_end_ - in_at_);
    std::memcpy(out.data(), in_.data() + in_at_, got);
    in_at_ += got;
    return got;
}

std::size_t ByteSource::read_gzip(std::span<std::byte> out) {
    if (in_at_ == in_end_ && read_file() == 0) {
        ended_ = true;
        return 0;
    }
    z_stream& stream = inflater_->stream;
    const unsigned before = narrow(out.size());
    stream.next_in = reinterpret_cast<unsigned char*>(in_.data() + in_at_);
    stream.avail_in = narrow(in_end_ - in_at_);
    stream.next_out = reinterpret_cast<unsigned char*>(out.data());
    stream.avail_out = before;
    const int result = inflate(&stream, Z_NO_FLUSH);
    in_at_ = in_end_ - stream.avail_in;
    // A gzip file may be several streams one after the other; what follows the last is no error.
    if (result == Z_STREAM_END) {
        bytes_after_end_ = unread_bytes_ + (in_end_ - in_at_);
        ended_ = inflateReset(&stream) != Z_OK;
    } else if (result != Z_OK && result != Z_BUF_ERROR) {
        ended_ = true;
        damaged_ = !between_streams_;
    }
    between_streams_ = result == Z_STREAM_END;
    return before - stream.avail_out;
}

std::size_t ByteSource::read_hex(std::span<std::byte> out) {
    std::size_t got = 0;
    int upper = -1;
    while (got < out.size()) {
        if (in_at_ == in_end_ && read_file() == 0) {
            ended_ = true;
            break;
        }
        const char c = in_[in_at_++];
        const int digit = hex_digit(c);
        if (digit < 0) {
            if (std::isspace(static_cast<unsigned char>(c)) == 0) {
                ended_ = true;
                break;
            }
        } else if (upper < 0) {
            upper = digit;
        } else {
            out[got++] = static_cast<std::byte>(upper * 16 + digit);
            upper = -1;
        }
    }
    return got;
}

std::string ByteSource::damage() const {
    const std::uint64_t ahead = in_end_ - in_at_;
    if (damaged_ && is_base64(encoding_)) {
        return fmt::format("; its compressed data are broken near byte {} of the file",
                           position_ - std::min(position_, base64_chars(ahead)));
    }
    if (damaged_) {
        return fmt::format("; its compressed data are broken at byte {} of the file",
                           position_ - ahead);
    }
    return is_cut()
               ? fmt::format("; its compressed data are cut: {} at byte {}, before their end",
                             position_ == size_bytes_ ? "the file ends" : "they stop", position_)
               : "";
}

std::uint64_t ByteSource::bytes_after_end() const {
    return bytes_after_end_;
}

std::uint64_t ByteSource::skip(std::uint64_t count) {
    std::vector<std::byte> passed(chunk_bytes);
    std::uint64_t skipped = 0;
    while (skipped < count) {
        const std::size_t wanted = std::min<std::uint64_t>(chunk_bytes, count - skipped);
        const std::size_t got = read(std::span(passed).first(wanted));
        skipped += got;
        if (got < wanted) {
            break;
        }
    }
    return skipped;
}

bool is_gzip(const std::filesystem::path& path) {
    std::array<unsigned char, 2> head{};
    std::ifstream(path, std::ios::binary).read(reinterpret_cast<char*>(head.data()), head.size());
    return head[0] == 0x1f && head[1] == 0x8b;
}

}  // namespace pxpl5::host::io
