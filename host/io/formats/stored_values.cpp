// The values that a stored header describes: decompressed, put into native byte order, gathered.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <type_traits>

#include "host/io/formats/stored_header.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t chunk_bytes = std::size_t{1} << 20;
constexpr std::size_t max_word_chars = 400;  // The longest float64 written out has 1077 digits,
                                             // but no program writes them.

static_assert(std::endian::native == std::endian::little);

void read_binary(const std::string& file, const StoredHeader& header, const fs::path& data,
                 std::uint64_t needed, ByteSource& source, ValueSink& sink) {
    std::vector<std::byte> chunk(std::min<std::uint64_t>(chunk_bytes, needed));
    const std::size_t size = component_bytes(header.component);
    for (std::uint64_t got = 0; got < needed;) {
        const std::span<std::byte> part =
            std::span(chunk).first(std::min<std::uint64_t>(chunk.size(), needed - got));
        const std::size_t came = source.read(part);
        if (came < part.size()) {
            throw too_short(file, header, data, got + came, source.damage());
        }
        if (header.big_endian) {
            swap_bytes(part, size);
        }
        sink.add(part, header.component, header.scale);
        got += came;
    }
}

/// One value as text, in the type that the header states.
template <typename T>
T parsed(const std::string& file, const StoredHeader& header, std::string_view word,
         std::uint64_t index) {
    const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
    const char* end = word.data() + word.size();
    T value{};
    auto [rest, failure] = std::from_chars(begin, end, value);
    if (failure == std::errc{} && rest == end && begin < end) {
        return value;
    }
    double wide = 0;
    const auto [wide_rest, wide_failure] = std::from_chars(begin, end, wide);
    if (wide_failure != std::errc{} || wide_rest != end || begin == end) {
        throw ImportError(fmt::format("{}: value {} is '{}', must be a number", file, index,
                                      shown(word.substr(0, 40))));
    }
    if (!(wide >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
          wide <= static_cast<double>(std::numeric_limits<T>::max())) ||
        (std::is_integral_v<T> && (sizeof(T) == 8 || std::trunc(wide) != wide))) {
        throw ImportError(fmt::format("{}: value {} is {}, which the type {} does not hold", file,
                                      index, shown(word.substr(0, 40)), header.type));
    }
    return static_cast<T>(wide);
}

/// Splits a stream of text into words.
class Words {
  public:
    /// ends_at_tag  A '<' is the end.
    Words(ByteSource& source, bool ends_at_tag)
        : source_(source), ends_at_tag_(ends_at_tag), chunk_(chunk_bytes) {}

    /// Returns an empty word at the end.
    std::string_view next() {
        word_.clear();
        while (!is_ended_) {
            if (at_ == end_) {
                at_ = 0;
                end_ = source_.read(std::as_writable_bytes(std::span(chunk_)));
                if (end_ == 0) {
                    return word_;
                }
            }
            const char c = chunk_[at_++];
            is_ended_ = ends_at_tag_ && c == '<';
            // Commas and braces separate in NRRD's text, blanks everywhere.
            const bool separates = c == ' ' || (c >= '\t' && c <= '\r') || c == ',' || c == '{' ||
                                   c == '}' || is_ended_;
            if (!separates) {
                word_.push_back(c);
            }
            if ((separates && !word_.empty()) || word_.size() >= max_word_chars) {
                return word_;
            }
        }
        return word_;
    }

  private:
    ByteSource& source_;
    bool ends_at_tag_;
    std::vector<char> chunk_;
    std::size_t at_ = 0, end_ = 0;
    bool is_ended_ = false;
    std::string word_;
};

void read_ascii(const std::string& file, const StoredHeader& header, std::uint64_t count,
                ByteSource& source, ValueSink& sink) {
    Words words(source, header.ends_at_tag);
    with_type(header.component, [&]<typename T>(T*) {
        std::vector<T> values;
        const std::uint64_t first = header.bytes_before() / sizeof(T), end = first + count;
        for (std::uint64_t index = 0; index < end; ++index) {
            const std::string_view word = words.next();
            if (word.empty()) {
                throw ImportError(fmt::format("{}: has {} values, its header states {}", file,
                                              index, count * header.frames));
            }
            if (index < first) {
                continue;
            }
            values.push_back(parsed<T>(file, header, word, index));
            if (values.size() * sizeof(T) >= chunk_bytes || index + 1 == end) {
                sink.add(std::as_bytes(std::span<const T>(values)), header.component, header.scale);
                values.clear();
            }
        }
        if (header.ends_at_tag && !words.next().empty()) {
            throw ImportError(
                fmt::format("{}: has more than the {} values that its header states", file, count));
        }
    });
}

/// The checksum comes after the last value.
void check_end(const std::string& file, const StoredHeader& header, const fs::path& data,
               ByteSource& source, Volume& volume) {
    constexpr std::uint64_t max_behind = std::uint64_t{64} << 20;  // A bomb goes on for long.
    constexpr std::uint64_t max_checked = std::uint64_t{1} << 30;
    const std::uint64_t behind = header.bytes_behind();
    if (behind > max_checked) {
        return;  // The checksum of so many other volumes takes too long.
    }
    const std::uint64_t there = source.skip(behind);
    if (there < behind && !source.is_damaged()) {
        volume.findings.push_back(cut_series(header, data, there));
        return;
    }
    const bool goes_on = source.skip(1) == 1;
    if (goes_on && is_compressed(header.encoding)) {
        source.skip(max_behind);
    }
    if (source.is_damaged() || ((goes_on || header.fits_exactly) && source.is_cut())) {
        throw ImportError(
            fmt::format("{}: the compressed data of {} are damaged: the checksum is "
                        "not that of its {} bytes",
                        file, data.filename().string(), needed_bytes(header)));
    }
    if (!goes_on && source.bytes_after_end() > 0) {
        volume.findings.push_back(
            {FindingKind::note,
             fmt::format("{} holds {} bytes after the end of its compressed data",
                         data.filename().string(), source.bytes_after_end())});
    }
    if (header.fits_exactly && goes_on) {
        throw ImportError(
            fmt::format("{}: {} of {} after {} bytes need {} bytes when decompressed, it has more",
                        file, join_sizes(header.sizes), header.type, header.byte_skip,
                        needed_bytes(header) + header.byte_skip));
    }
    if (header.ends_file && goes_on) {
        volume.findings.push_back(
            {FindingKind::note,
             fmt::format("{} holds more bytes than the header states", data.filename().string())});
    }
}

}  // namespace

ImportError too_short(const std::string& file, const StoredHeader& header, const fs::path& data,
                      std::uint64_t got, const std::string& damage) {
    const std::uint64_t needed =
        (header.at_end ? header.frames : 1) * needed_bytes(header) / header.data_files.size();
    const bool is_one_of_many = header.frames > 1 && !header.at_end;
    return ImportError(fmt::format(
        "{}: {}{} of {} need {} bytes{}, {} has {}{}{}", file,
        is_one_of_many ? fmt::format("volume {} of {}: ", header.frame, header.frames) : "",
        join_sizes(header.sizes), header.type, needed,
        is_compressed(header.encoding) ? " when decompressed" : "", data.filename().string(), got,
        is_one_of_many ? " of them" : "", damage));
}

std::uint64_t offset_after_lines(const std::string& file, const fs::path& path,
                                 std::uint64_t offset, std::uint64_t lines) {
    std::ifstream stream(path, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(offset));
    for (std::uint64_t line = 0; line < lines; ++line) {
        stream.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
        if (!stream || stream.eof()) {
            throw ImportError(
                fmt::format("{}: line skip is {}, but only {} lines follow", file, lines, line));
        }
    }
    const auto at = stream.tellg();
    return at < 0 ? offset : static_cast<std::uint64_t>(at);
}

Volume empty_volume(const fs::path& path, const StoredHeader& header) {
    const std::array<int, 3> dims = volume_dims(path.string(), header.sizes);
    Volume volume;
    volume.nx = dims[0];
    volume.ny = dims[1];
    volume.nz = dims[2];
    volume.voxel_to_patient = header.voxel_to_patient;
    volume.findings = header.findings;
    volume.frame = header.series_frame;
    volume.frames = header.series_frames;
    volume.frame_ms =
        header.series_frames > 1 && header.frame_ms <= max_frame_ms ? header.frame_ms : 0;
    return volume;
}

/// A data file, and how far it has been read.
struct StoredReader::Open {
    Open(const fs::path& path, const fs::path& data, const StoredHeader& header)
        : name(data),
          file(path, data, header.allowed),
          offset(header.line_skip == 0 ? header.offset_bytes
                                       : offset_after_lines(data.string(), file.path(),
                                                            header.offset_bytes, header.line_skip)),
          source(file.path(), header.encoding, offset, header.compressed_bytes) {}

    fs::path name;
    DataFile file;
    std::uint64_t offset;  ///< The first byte of `source` in the file.
    ByteSource source;
    std::uint64_t passed = 0;  ///< Bytes that `source` has given.
};

StoredReader::StoredReader() = default;
StoredReader::~StoredReader() = default;

/// The data file, from where the volume before ended if that lies before the wanted one.
std::unique_ptr<StoredReader::Open> StoredReader::open(const fs::path& path,
                                                       const StoredHeader& header,
                                                       const fs::path& data) {
    std::unique_ptr<Open> last = std::move(open_);
    const bool goes_on = last && last->name == data && !header.at_end &&
                         header.byte_skip + header.bytes_before() >= last->passed;
    return goes_on ? std::move(last) : std::make_unique<Open>(path, data, header);
}

/// Passes over what comes before the values.
void StoredReader::skip_to_values(const std::string& file, const StoredHeader& header,
                                  const fs::path& data, std::uint64_t needed, Open& opened) {
    std::uint64_t skip = header.byte_skip + header.bytes_before();
    if (header.at_end) {
        const std::uint64_t file_bytes = opened.file.size_bytes();
        const std::uint64_t all =
            header.encoding == Encoding::raw
                ? file_bytes - std::min(file_bytes, opened.offset)
                : ByteSource(opened.file.path(), header.encoding, opened.offset)
                      .skip(std::numeric_limits<std::uint64_t>::max());
        const std::uint64_t volumes = header.frames * needed;
        if (all < volumes) {
            throw too_short(file, header, data, all);
        }
        skip = all - volumes + header.bytes_before();
    }
    opened.passed += opened.source.skip(skip - opened.passed);
    if (opened.passed < skip) {
        throw ImportError(fmt::format(
            "{}: {} after {} bytes{}, {} has {}{}", file,
            header.frames > 1 ? fmt::format("volume {} of {} begins", header.frame, header.frames)
                              : "values begin",
            skip, is_compressed(header.encoding) ? ", decompressed" : "", data.filename().string(),
            opened.passed, opened.source.damage()));
    }
}

Volume StoredReader::read(const fs::path& path, const StoredHeader& header, bool later_follow) {
    const std::string file = path.string();
    check_volume_bytes(file, fmt::format("{} of {}", join_sizes(header.sizes), header.type),
                       needed_bytes(header));
    Volume volume = empty_volume(path, header);
    const std::uint64_t needed = needed_bytes(header), share = needed / header.data_files.size();
    const std::size_t size = component_bytes(header.component);
    ValueSink sink(needed / size);
    for (const fs::path& data : header.data_files) {
        std::unique_ptr<Open> opened = open(path, header, data);
        if (header.encoding == Encoding::ascii) {
            read_ascii(file, header, share / size, opened->source, sink);
            continue;
        }
        skip_to_values(file, header, data, share, *opened);
        read_binary(file, header, data, share, opened->source, sink);
        opened->passed += share;
        if (!is_compressed(header.encoding)) {
            continue;
        }
        if (later_follow && header.frame < header.frames && header.data_files.size() == 1) {
            open_ = std::move(opened);
        } else {
            check_end(file, header, data, opened->source, volume);
        }
    }
    sink.finish(file, volume);
    return volume;
}

}  // namespace pxpl5::host::io
