// VTK XML image data (.vti): one array of points, as text, in base64 or appended, in zlib or not.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "host/io/formats/stored_header.hpp"
#include "host/io/formats/vti_markup.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

/// The value of an attribute, or `otherwise`.
std::string value_of(const TagAttributes& tag, const char* name, const char* otherwise = "") {
    const auto found = tag.find(name);
    return found == tag.end() ? otherwise : found->second;
}

/// One of the values that an attribute may have, by its place in the list.
/// Throws ImportError naming them all.
template <std::size_t count>
std::size_t one_of(const std::string& file, const char* name, const std::string& value,
                   const std::array<const char*, count>& all) {
    const auto found = std::ranges::find(all, value);
    if (found == all.end()) {
        throw ImportError(fmt::format("{}: {} is '{}', must be one of: {}", file, name,
                                      shown(value), fmt::join(all, ", ")));
    }
    return static_cast<std::size_t>(found - all.begin());
}

std::vector<double> numbers_of(const std::string& file, const TagAttributes& tag, const char* name,
                               const char* otherwise, std::size_t count) {
    const std::string text = value_of(tag, name, otherwise);
    std::vector<double> all = numbers(file, name, text);
    if (all.size() != count) {
        throw ImportError(
            fmt::format("{}: {} is '{}', must be {} numbers", file, name, shown(text), count));
    }
    return all;
}

/// The sizes, and the index of the first voxel along each axis.
glm::dvec3 take_extent(const std::string& file, const VtiMarkup& markup, StoredHeader& header) {
    const std::string whole = value_of(markup.image, "WholeExtent");
    const std::string piece = value_of(markup.piece, "Extent", whole.c_str());
    const std::vector<double> extent = numbers_of(file, markup.image, "WholeExtent", "", 6);
    if (numbers(file, "Extent", piece) != extent) {
        throw ImportError(fmt::format("{}: its first piece is {}, must be the WholeExtent, {}",
                                      file, shown(piece), shown(whole)));
    }
    glm::dvec3 first{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = 2 * static_cast<std::size_t>(axis);
        first[axis] = extent[at];
        const double size = extent[at + 1] - extent[at] + 1;
        if (!(size >= 1 && size <= max_volume_voxels && std::trunc(first[axis]) == first[axis] &&
              std::trunc(size) == size)) {
            throw ImportError(fmt::format("{}: {} voxels along {}, must be 1 to {}", file, size,
                                          "xyz"[axis], max_volume_voxels));
        }
        header.sizes.push_back(static_cast<std::uint64_t>(size));
    }
    volume_dims(file, header.sizes);
    return first;
}

/// The affine. `first`: the index of the first voxel; the origin is that of the index 0.
void take_place(const std::string& file, const VtiMarkup& markup, glm::dvec3 first,
                const std::string& orientation, StoredHeader& header) {
    const auto spacing = numbers_of(file, markup.image, "Spacing", "1 1 1", 3);
    const auto origin = numbers_of(file, markup.image, "Origin", "0 0 0", 3);
    const auto rows = numbers_of(file, markup.image, "Direction", "1 0 0 0 1 0 0 0 1", 9);
    // The origin is that of the index 0, so another spacing would move the first voxel.
    header.spacing_stated.fill(markup.image.contains("Spacing") || first != glm::dvec3(0.0));
    glm::dvec3 place(origin[0], origin[1], origin[2]);
    for (int column = 0; column < 3; ++column) {
        const auto at = static_cast<std::size_t>(column);
        const glm::dvec3 axis = glm::dvec3(rows[at], rows[at + 3], rows[at + 6]) * spacing[at];
        header.voxel_to_patient[column] = glm::dvec4(axis, 0.0);
        place += axis * first[column];
    }
    header.voxel_to_patient[3] = glm::dvec4(place, 1.0);
    const bool is_turned = rows != std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (is_turned && !orientation.empty()) {
        throw ImportError(
            fmt::format("{}: Direction is '{}', so its axes are not x, y, z, and "
                        "orientation= cannot be given",
                        file, shown(value_of(markup.image, "Direction"))));
    }
    header.assumed_directions =
        "VTK files state no patient space: x, y, z are taken as left, posterior, superior";
}

void take_type(const std::string& file, const VtiMarkup& markup, StoredHeader& header) {
    const std::string type = value_of(markup.array, "type");
    const std::optional<Component> component = component_named(type);
    if (!component) {
        throw ImportError(
            fmt::format("{}: the type of its array is '{}', must be Int8, UInt8, ..., Int64, "
                        "UInt64, Float32 or Float64",
                        file, shown(type)));
    }
    const std::string components = value_of(markup.array, "NumberOfComponents", "1");
    if (components != "1") {
        throw ImportError(fmt::format("{}: its array has {} components, a volume has 1", file,
                                      shown(components)));
    }
    header.type = type;
    header.component = *component;
}

/// The byte of the first character from `at` that is no white space.
std::uint64_t first_text(const fs::path& path, std::uint64_t at) {
    std::ifstream stream(path, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(at));
    stream >> std::ws;
    const auto found = stream.tellg();
    return found < 0 ? at : static_cast<std::uint64_t>(found);
}

/// Whole numbers that precede the values.
class Lengths {
  public:
    Lengths(const fs::path& path, bool is_text, bool is_wide, bool big_endian)
        : path_(path),
          encoding_(is_text ? Encoding::base64 : Encoding::raw),
          bytes_(is_wide ? 8 : 4),
          big_endian_(big_endian) {}

    /// How many bytes of the file `count` numbers take, if nothing follows in the same base64.
    std::uint64_t stored_bytes(std::uint64_t count) const {
        return encoding_ == Encoding::base64 ? base64_chars(count * bytes_) : count * bytes_;
    }
    std::uint64_t number_bytes() const { return bytes_; }

    /// `count` numbers from byte `at` on.
    std::vector<std::uint64_t> read(std::uint64_t at, std::uint64_t count) const {
        const std::uint64_t there = fs::file_size(path_) - std::min(at, fs::file_size(path_));
        std::vector<std::byte> bytes(
            count <= there / bytes_ ? static_cast<std::size_t>(count * bytes_) : 0);
        if (count == 0 || bytes.empty() ||
            ByteSource(path_, encoding_, at).read(bytes) < bytes.size()) {
            throw ImportError(fmt::format(
                "{}: its values should begin at byte {} with {} lengths, but the file ends",
                path_.string(), at, count));
        }
        std::vector<std::uint64_t> all(static_cast<std::size_t>(count));
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            const std::size_t digit = i % bytes_, shift = big_endian_ ? bytes_ - 1 - digit : digit;
            all[i / bytes_] |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * shift);
        }
        return all;
    }

  private:
    const fs::path& path_;
    Encoding encoding_;
    std::size_t bytes_;  ///< Size of a number.
    bool big_endian_;
};

void check_bytes(const std::string& file, const StoredHeader& header, std::uint64_t stated) {
    if (stated != needed_bytes(header)) {
        throw ImportError(fmt::format("{}: {} of {} need {} bytes, its array has {}", file,
                                      join_sizes(header.sizes), header.type, needed_bytes(header),
                                      stated));
    }
}

/// Compressed values lie in blocks. Their number, their size, that of a smaller last one (or 0) and
/// the compressed size of each precede them.
void take_blocks(const std::string& file, const Lengths& lengths, std::uint64_t at,
                 StoredHeader& header) {
    const std::vector<std::uint64_t> head = lengths.read(at, 3);
    const std::uint64_t blocks = head[0], block = head[1], last = head[2];
    const std::uint64_t whole = blocks - (last == 0 ? 0 : 1);  // Blocks of the full size.
    constexpr std::uint64_t most = std::uint64_t{1} << 31;     // Products do not overflow.
    if (blocks == 0 || blocks > most || block > most || last > most) {
        throw ImportError(
            fmt::format("{}: its array states {} compressed blocks of {} bytes, the last of {}; "
                        "must be 1 or more, each number at most {}",
                        file, blocks, block, last, most));
    }
    check_bytes(file, header, whole * block + last);
    const std::uint64_t file_bytes = fs::file_size(header.data_files.front());
    const std::vector<std::uint64_t> all = lengths.read(at, 3 + blocks);
    std::uint64_t compressed = 0;
    for (std::size_t i = 3; i < all.size(); ++i) {
        if (all[i] > file_bytes - std::min(file_bytes, compressed)) {
            throw ImportError(
                fmt::format("{}: its compressed block {} has {} bytes, the file has "
                            "{}",
                            file, i - 2, all[i], file_bytes));
        }
        compressed += all[i];
    }
    const bool is_text = is_base64(header.encoding);
    header.encoding = is_text ? Encoding::gzip_base64 : Encoding::gzip;
    header.offset_bytes = at + lengths.stored_bytes(3 + blocks);
    header.compressed_bytes = is_text ? base64_chars(compressed) : compressed;
    header.fits_exactly = true;
}

/// Where the values are, and how.
void take_values(const fs::path& path, const VtiMarkup& markup, StoredHeader& header) {
    const std::string file = path.string();
    const std::size_t format = one_of(file, "format", value_of(markup.array, "format", "ascii"),
                                      std::array{"ascii", "binary", "appended"});
    std::uint64_t at = first_text(path, markup.values_at);
    header.data_files = {path};
    if (format == 0) {
        header.encoding = Encoding::ascii;
        header.offset_bytes = at;
        header.ends_at_tag = true;
        return;
    }
    bool is_text = true;
    if (format == 2) {
        is_text = one_of(file, "encoding", value_of(markup.appended, "encoding", "base64"),
                         std::array{"raw", "base64"}) == 1;
        char mark = 0;
        std::ifstream stream(path, std::ios::binary);
        stream.seekg(static_cast<std::streamoff>(at)).get(mark);
        const std::string text = value_of(markup.array, "offset");
        const std::vector<std::uint64_t> offset = whole_numbers(file, "offset", text);
        if (offset.size() != 1) {
            throw ImportError(fmt::format("{}: the offset of its array is '{}', must be a number",
                                          file, shown(text)));
        }
        if (mark != '_' || offset[0] > fs::file_size(path)) {
            throw ImportError(fmt::format(
                "{}: its values begin {} bytes behind the '_' of AppendedData, which {}", file,
                shown(text), mark == '_' ? "is behind the end of the file" : "it lacks"));
        }
        at += 1 + offset[0];
    }
    header.big_endian =
        one_of(file, "byte_order", value_of(markup.file, "byte_order", "LittleEndian"),
               std::array{"LittleEndian", "BigEndian"}) == 1;
    const bool is_wide = one_of(file, "header_type", value_of(markup.file, "header_type", "UInt32"),
                                std::array{"UInt32", "UInt64"}) == 1;
    const bool has_blocks = one_of(file, "compressor", value_of(markup.file, "compressor"),
                                   std::array{"", "vtkZLibDataCompressor"}) == 1;
    const Lengths lengths(path, is_text, is_wide, header.big_endian);
    header.encoding = is_text ? Encoding::base64 : Encoding::raw;
    if (has_blocks) {
        take_blocks(file, lengths, at, header);
        return;
    }
    check_bytes(file, header, lengths.read(at, 1)[0]);
    header.offset_bytes = is_text ? at : at + lengths.number_bytes();
    header.byte_skip = is_text ? lengths.number_bytes() : 0;
}

}  // namespace

StoredHeader read_vti_header(const fs::path& path, const std::string& orientation) {
    const std::string file = path.string();
    const VtiMarkup markup = read_vti_markup(path);
    StoredHeader header;
    const glm::dvec3 first = take_extent(file, markup, header);
    take_type(file, markup, header);
    take_values(path, markup, header);
    take_place(file, markup, first, orientation, header);
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
