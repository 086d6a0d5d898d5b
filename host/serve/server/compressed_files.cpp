#include "host/serve/server/compressed_files.hpp"

#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <ranges>
#include <system_error>
#include <utility>

namespace pxpl5::host::serve {
namespace {

constexpr int gzip_level = 6, gzip_window_bits = 15 + 16, gzip_memory_level = 8;

std::optional<std::string> gzip_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::string plain{std::istreambuf_iterator<char>(file), {}};
    z_stream stream{};
    if (!file.is_open() || file.bad() ||
        deflateInit2(&stream, gzip_level, Z_DEFLATED, gzip_window_bits, gzip_memory_level,
                     Z_DEFAULT_STRATEGY) != Z_OK) {
        return std::nullopt;
    }
    std::string gzip(deflateBound(&stream, plain.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(plain.data());
    stream.avail_in = static_cast<uInt>(plain.size());
    stream.next_out = reinterpret_cast<Bytef*>(gzip.data());
    stream.avail_out = static_cast<uInt>(gzip.size());
    const bool is_done = deflate(&stream, Z_FINISH) == Z_STREAM_END;
    gzip.resize(gzip.size() - stream.avail_out);
    deflateEnd(&stream);
    return is_done ? std::optional(std::move(gzip)) : std::nullopt;
}

std::string_view trimmed(std::string_view text) {
    const std::size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
    text.remove_prefix(begin);
    return text.substr(0, text.find_last_not_of(" \t") + 1);
}

}  // namespace

const std::string* CompressedFiles::find(const std::filesystem::path& file) {
    std::error_code error;
    const auto written = std::filesystem::last_write_time(file, error);
    const std::uintmax_t bytes = error ? 0 : std::filesystem::file_size(file, error);
    if (error) {
        return nullptr;
    }
    Compressed& kept = files_[file];
    if (kept.gzip.empty() || kept.written != written || kept.bytes != bytes) {
        const std::optional<std::string> made = gzip_of(file);
        kept = {written, bytes, made.value_or("")};
    }
    return kept.gzip.empty() ? nullptr : &kept.gzip;
}

bool accepts_gzip(std::string_view accept_encoding) {
    for (const auto part : std::views::split(accept_encoding, ',')) {
        const std::string_view entry(part.begin(), part.end());
        const std::size_t semicolon = std::min(entry.find(';'), entry.size());
        if (trimmed(entry.substr(0, semicolon)) != "gzip") {
            continue;
        }
        // A weight is 0 if it has no digit but 0: "q=0", "q=0.000".
        const std::string_view weight = entry.substr(semicolon);
        return weight.empty() || weight.find_first_of("123456789") != std::string_view::npos;
    }
    return false;
}

}  // namespace pxpl5::host::serve
