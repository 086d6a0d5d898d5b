#include "host/io/zarr/zarr_array.hpp"

#include <blosc.h>
#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>

#include "host/base/json_depth.hpp"
#include "host/io/formats/byte_source.hpp"
#include "host/io/values/component.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/import_request.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr std::uint64_t max_json_bytes = std::uint64_t{4} << 20;
constexpr int max_json_depth = 32;
constexpr std::uint64_t max_chunk_bytes = std::uint64_t{1} << 30;
constexpr std::uint64_t codec_extra_bytes = std::uint64_t{64} << 10;
constexpr std::size_t max_axes = 5;  // Time, channel, z, y, x.

/// A field's value as an error shows it.
std::string shown_field(const Json& json, const char* name) {
    return json.contains(name) ? shown(json[name].dump(-1, ' ', true).substr(0, 200)) : "missing";
}

[[noreturn]] void refuse(const fs::path& folder, const Json& json, const char* name,
                         const std::string& want) {
    throw ImportError(fmt::format("{}: {} is {}, must be {}", (folder / ".zarray").string(), name,
                                  shown_field(json, name), want));
}

std::vector<std::uint64_t> sizes_of(const fs::path& folder, const Json& json, const char* name,
                                    std::size_t axes) {
    constexpr std::uint64_t max_size = std::uint64_t{1} << 32;
    const Json list = json.value(name, Json());
    std::vector<std::uint64_t> sizes;
    for (const Json& size : list.is_array() && list.size() <= max_axes ? list : Json::array()) {
        sizes.push_back(size.is_number_unsigned() ? size.get<std::uint64_t>() : 0);
    }
    const bool is_right = !sizes.empty() && (axes == 0 || sizes.size() == axes) &&
                          std::ranges::all_of(sizes, [](std::uint64_t size) {
                              return size >= 1 && size <= max_size;
                          });
    if (!is_right) {
        refuse(folder, json, name,
               axes == 0 ? fmt::format("2 to {} whole numbers above 0", max_axes)
                         : fmt::format("{} whole numbers above 0, as of shape", axes));
    }
    return sizes;
}

/// "<i2": byte order, kind and bytes of a value.
void take_type(const Json& json, ZarrArray& array) {
    const Json text = json.value("dtype", Json());
    const std::string type = text.is_string() ? text.get<std::string>() : "";
    constexpr std::array<std::pair<std::string_view, const char*>, 10> kinds = {{
        {"u1", "uint8"},
        {"i1", "int8"},
        {"u2", "uint16"},
        {"i2", "int16"},
        {"u4", "uint32"},
        {"i4", "int32"},
        {"u8", "uint64"},
        {"i8", "int64"},
        {"f4", "float32"},
        {"f8", "float64"},
    }};
    const auto kind = std::ranges::find_if(
        kinds, [&](const auto& each) { return type.size() == 3 && type.substr(1) == each.first; });
    const char order = type.empty() ? ' ' : type[0];
    if (kind == kinds.end() || (order != '<' && order != '>' && order != '|')) {
        refuse(array.folder, json, "dtype",
               "a byte order and a type, as <u1, <i2, >u2, <f4 or <f8");
    }
    array.component = *component_named(kind->second);
    array.big_endian = order == '>';
}

void take_codec(const Json& json, ZarrArray& array) {
    const Json codec = json.value("compressor", Json());
    if (codec.is_null()) {
        return;
    }
    const Json name = codec.is_object() ? codec.value("id", Json()) : Json();
    if (name == "zlib" || name == "gzip") {
        array.codec = ZarrCodec::zlib;
    } else if (name == "zstd") {
        array.codec = ZarrCodec::zstd;
    } else if (name == "blosc") {
        array.codec = ZarrCodec::blosc;
    } else {
        refuse(array.folder, json, "compressor", "null, zlib, gzip, zstd or blosc");
    }
}

/// The bytes of the fill value in the array's type.
void take_fill(const Json& json, ZarrArray& array) {
    const Json fill = json.value("fill_value", Json());
    double value = fill.is_number() ? fill.get<double>() : 0;
    bool is_right = fill.is_null() || fill.is_number();
    if (fill == "NaN" || fill == "Infinity" || fill == "-Infinity") {
        is_right = array.component == Component::float32 || array.component == Component::float64;
        value = fill == "NaN" ? std::numeric_limits<double>::quiet_NaN()
                              : std::copysign(std::numeric_limits<double>::infinity(),
                                              fill == "Infinity" ? 1 : -1);
    }
    with_type(array.component, [&]<typename T>(T*) {
        if constexpr (std::is_integral_v<T>) {
            is_right = is_right && std::trunc(value) == value &&
                       value >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
                       value <= static_cast<double>(std::numeric_limits<T>::max()) &&
                       std::abs(value) < 9e18;
        }
        const T typed = is_right ? static_cast<T>(value) : T{};
        const auto bytes = std::as_bytes(std::span(&typed, 1));
        array.fill.assign(bytes.begin(), bytes.end());
    });
    if (!is_right) {
        refuse(array.folder, json, "fill_value",
               fmt::format("null or a value of {}", component_name(array.component)));
    }
    if (array.big_endian) {
        std::ranges::reverse(array.fill);
    }
    array.fill_text =
        fill.is_null() ? "0, as its fill_value is null" : fmt::format("{}, the fill value", value);
}

std::vector<std::byte> bytes_of_file(const DataFile& file) {
    std::vector<std::byte> bytes(static_cast<std::size_t>(file.size_bytes()));
    std::ifstream stream(file.path(), std::ios::binary);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    return bytes;
}

[[noreturn]] void refuse_chunk(const fs::path& path, const std::string& got, std::size_t wanted) {
    throw ImportError(
        fmt::format("{}: has {} bytes of values, a chunk has {}", path.string(), got, wanted));
}

[[noreturn]] void refuse_damage(const fs::path& path) {
    throw ImportError(path.string() + ": its compressed data are damaged");
}

/// Plain values, and those in zlib or gzip.
void read_stream(const fs::path& path, const DataFile& file, Encoding encoding,
                 std::span<std::byte> out) {
    ByteSource source(file.path(), encoding, 0);
    const std::size_t got = source.read(out);
    const bool has_more = got == out.size() && source.skip(1) == 1;
    if (source.is_damaged() || source.is_cut()) {
        refuse_damage(path);
    }
    if (has_more || got < out.size()) {
        refuse_chunk(path, has_more ? fmt::format("more than {}", got) : fmt::format("{}", got),
                     out.size());
    }
}

void read_zstd(const fs::path& path, std::span<const std::byte> packed, std::span<std::byte> out) {
    const unsigned long long stated = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (stated < ZSTD_CONTENTSIZE_ERROR && stated != out.size()) {
        refuse_chunk(path, fmt::format("{}", stated), out.size());
    }
    if (ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size()) != out.size()) {
        refuse_damage(path);
    }
}

void read_blosc(const fs::path& path, std::span<const std::byte> packed, std::span<std::byte> out) {
    std::size_t stated = 0;
    if (blosc_cbuffer_validate(packed.data(), packed.size(), &stated) != 0) {
        refuse_damage(path);
    }
    if (stated != out.size()) {
        refuse_chunk(path, fmt::format("{}", stated), out.size());
    }
    const int got = blosc_decompress_ctx(packed.data(), out.data(), out.size(), 1);
    if (got < 0 || static_cast<std::size_t>(got) != out.size()) {
        refuse_damage(path);
    }
}

}  // namespace

std::uint64_t ZarrArray::chunk_bytes() const {
    std::uint64_t bytes = component_bytes(component);
    for (const std::uint64_t size : chunks) {
        bytes = std::min(bytes * size, std::uint64_t{1} << 62);  // Sizes are at most 2^32.
        if (bytes > max_chunk_bytes) {
            return bytes;
        }
    }
    return bytes;
}

Json read_json(const fs::path& path, const fs::path& anchor, const AllowedFolders& allowed) {
    const DataFile file(anchor, path, allowed);
    if (file.size_bytes() > max_json_bytes) {
        throw ImportError(fmt::format("{}: has {} bytes, must have at most {}", path.string(),
                                      file.size_bytes(), max_json_bytes));
    }
    const std::vector<std::byte> bytes = bytes_of_file(file);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    ParsedJson parsed = parse_json(text, max_json_depth);
    if (parsed.levels > max_json_depth) {
        throw ImportError(
            fmt::format("{}: nests deeper than {} levels", path.string(), max_json_depth));
    }
    if (!parsed.json.is_object()) {
        throw ImportError(path.string() + ": is no JSON object");
    }
    return std::move(parsed.json);
}

ZarrArray read_zarr_array(const fs::path& folder, const fs::path& anchor,
                          const AllowedFolders& allowed) {
    const Json json = read_json(folder / ".zarray", anchor, allowed);
    ZarrArray array;
    array.folder = folder;
    array.anchor = anchor;
    if (json.value("zarr_format", Json()) != 2) {
        refuse(folder, json, "zarr_format", "2");
    }
    array.shape = sizes_of(folder, json, "shape", 0);
    array.chunks = sizes_of(folder, json, "chunks", array.shape.size());
    take_type(json, array);
    take_codec(json, array);
    take_fill(json, array);
    const Json filters = json.value("filters", Json());
    if (!filters.is_null() && !filters.empty()) {
        refuse(folder, json, "filters", "null");
    }
    const Json order = json.value("order", Json("C"));
    if (order != "C" && order != "F") {
        refuse(folder, json, "order", "\"C\" or \"F\"");
    }
    array.is_c_order = order == "C";
    const Json separator = json.value("dimension_separator", Json("."));
    if (separator != "." && separator != "/") {
        refuse(folder, json, "dimension_separator", "\".\" or \"/\"");
    }
    array.separator = separator.get<std::string>();
    if (array.chunk_bytes() > max_chunk_bytes) {
        refuse(folder, json, "chunks", fmt::format("chunks of at most {} bytes", max_chunk_bytes));
    }
    return array;
}

fs::path chunk_file(const ZarrArray& array, std::span<const std::uint64_t> index) {
    return array.folder / fmt::format("{}", fmt::join(index, array.separator));
}

bool has_chunk_file(const ZarrArray& array, std::span<const std::uint64_t> index) {
    const fs::path path = chunk_file(array, index);
    std::error_code failure;
    const fs::file_type type = fs::symlink_status(path, failure).type();
    if (type == fs::file_type::none) {  // It may be there.
        throw ImportError(fmt::format("{}: {}", path.string(), failure.message()));
    }
    return type != fs::file_type::not_found;
}

void read_chunk(const ZarrArray& array, std::span<const std::uint64_t> index,
                const AllowedFolders& allowed, std::span<std::byte> out) {
    const fs::path path = chunk_file(array, index);
    if (!has_chunk_file(array, index)) {
        for (std::size_t at = 0; at < out.size(); at += array.fill.size()) {
            std::ranges::copy(array.fill, out.begin() + static_cast<std::ptrdiff_t>(at));
        }
        return;
    }
    const DataFile file(array.anchor, path, allowed);
    const std::uint64_t most = out.size() + out.size() / 8 + codec_extra_bytes;
    if (file.size_bytes() > most) {
        throw ImportError(fmt::format("{}: has {} bytes, a chunk of {} bytes has at most {}",
                                      path.string(), file.size_bytes(), out.size(), most));
    }
    switch (array.codec) {
        case ZarrCodec::none:
            return read_stream(path, file, Encoding::raw, out);
        case ZarrCodec::zlib:
            return read_stream(path, file, Encoding::gzip, out);
        case ZarrCodec::zstd:
            return read_zstd(path, bytes_of_file(file), out);
        case ZarrCodec::blosc:
            return read_blosc(path, bytes_of_file(file), out);
    }
}

}  // namespace pxpl5::host::io
