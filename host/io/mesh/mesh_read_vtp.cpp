#include <fmt/format.h>
#include <zlib.h>

#include <charconv>
#include <cstring>
#include <map>

#include "host/io/mesh/mesh_export.hpp"
#include "host/io/mesh/mesh_polygon.hpp"
#include "host/io/values/base64.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::uint64_t max_zlib_ratio = 1032;  // Deflate's best.

/// A DataArray and where its values are.
struct Array {
    std::string type, format;
    std::string_view text;     ///< Between its tags.
    std::uint64_t offset = 0;  ///< In the appended data.
};

std::string attribute(std::string_view tag, std::string_view name) {
    const std::string start = fmt::format(" {}=\"", name);
    const std::size_t at = tag.find(start);
    const std::size_t end = tag.find('"', at + start.size());
    return at == std::string_view::npos || end == std::string_view::npos
               ? ""
               : std::string(tag.substr(at + start.size(), end - at - start.size()));
}

std::uint64_t whole(std::string_view text) {
    std::uint64_t number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

std::string from_base64(std::string_view text) {
    std::string bytes;
    unsigned bits = 0, count = 0;
    for (const char c : text) {
        const int digit = base64_digit(c);
        if (digit < 0) continue;  // Padding.
        bits = bits << 6 | static_cast<unsigned>(digit);
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes += static_cast<char>(bits >> count & 0xFF);
        }
    }
    return bytes;
}

class VtpFile {
  public:
    VtpFile(const std::string& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

    MeshFile run() {
        const std::string_view head = next_tag("<VTKFile");
        if (attribute(head, "type") != "PolyData") fail("is not VTK's PolyData in XML");
        const std::string compressor = attribute(head, "compressor");
        if (!compressor.empty() && compressor != "vtkZLibDataCompressor") {
            fail("is compressed by " + compressor + ", must be vtkZLibDataCompressor or none");
        }
        if (attribute(head, "byte_order") == "BigEndian") fail("is big-endian, which is not read");
        is_compressed_ = !compressor.empty();
        header_bytes_ = attribute(head, "header_type") == "UInt64" ? 8 : 4;
        if (const std::size_t at = bytes_.find("<AppendedData"); at != std::string_view::npos) {
            const std::string_view tag = bytes_.substr(at, bytes_.find('>', at) - at);
            is_base64_ = attribute(tag, "encoding") == "base64";
            const std::size_t mark = bytes_.find('_', at + tag.size());
            if (mark == std::string_view::npos) fail("has appended data without their '_'");
            appended_ = bytes_.substr(mark + 1);
            bytes_ = bytes_.substr(0, at);
        }
        while (bytes_.find("<Piece", at_) != std::string_view::npos) {
            add_piece(next_tag("<Piece"));
        }
        return std::move(out_);
    }

  private:
    [[noreturn]] void fail(const std::string& reason) const {
        throw MeshError(path_ + ": " + reason);
    }

    std::string_view next_tag(std::string_view start) {
        const std::size_t at = bytes_.find(start, at_), end = bytes_.find('>', at);
        if (at == std::string_view::npos || end == std::string_view::npos) {
            fail(fmt::format("has no {}>", start));
        }
        at_ = end + 1;
        return bytes_.substr(at, end - at);
    }

    Array next_array() {
        const std::string_view tag = next_tag("<DataArray");
        Array array{
            attribute(tag, "type"), attribute(tag, "format"), {}, whole(attribute(tag, "offset"))};
        if (tag.back() != '/') {
            array.text = bytes_.substr(at_, bytes_.find('<', at_) - at_);
        }
        return array;
    }

    void add_piece(std::string_view piece) {
        const std::uint64_t count = whole(attribute(piece, "NumberOfPolys"));
        if (whole(attribute(piece, "NumberOfStrips")) > 0) fail("has strips, which are not read");
        const std::size_t begin = at_;
        next_tag("<Points");
        const std::vector<double> places = values_of(next_array());
        const auto before = static_cast<std::uint32_t>(out_.points.size());
        for (std::size_t i = 0; i + 2 < places.size(); i += 3) {
            out_.points.emplace_back(places[i], places[i + 1], places[i + 2]);
        }
        if (count == 0) return;
        at_ = begin;
        next_tag("<Polys");
        std::map<std::string, Array> arrays;
        for (int i = 0; i < 2; ++i) {
            const std::size_t before_tag = at_;
            const std::string name = attribute(next_tag("<DataArray"), "Name");
            at_ = before_tag;
            arrays[name] = next_array();
        }
        const std::vector<double> corners = values_of(arrays["connectivity"]),
                                  ends = values_of(arrays["offsets"]);
        std::size_t first = 0;
        for (const double end : ends) {
            // Also false for a NaN, which text may hold.
            const bool is_place = end >= 0 && end <= static_cast<double>(corners.size());
            if (!is_place) fail("offsets are broken");
            std::vector<std::uint32_t> polygon;
            for (std::size_t i = first; i < static_cast<std::size_t>(end); ++i) {
                const std::size_t points = places.size() / 3;
                if (!(corners[i] >= 0 && corners[i] < static_cast<double>(points))) {
                    fail(fmt::format("has index {} of {} points", corners[i], points));
                }
                polygon.push_back(before + static_cast<std::uint32_t>(corners[i]));
            }
            add_polygon(out_, polygon);
            first = static_cast<std::size_t>(end);
        }
    }

    std::vector<double> values_of(const Array& array) const {
        if (array.format == "ascii") {
            std::vector<double> values;
            const std::string text(array.text);
            char* end = nullptr;
            for (const char* at = text.c_str();; at = end) {
                const double value = std::strtod(at, &end);
                if (end == at) return values;
                values.push_back(value);
            }
        }
        const bool is_appended = array.format == "appended";
        if (is_appended && array.offset > appended_.size()) fail("appended data are missing");
        std::string_view data = is_appended ? appended_.substr(array.offset) : array.text;
        data.remove_prefix(
            std::min(data.find_first_not_of(" \t\r\n"), is_appended ? 0 : data.size()));
        const std::string bytes = block(data, is_base64_ || !is_appended);
        const std::string& t = array.type;
        if (t == "Float32") return as<float>(bytes);
        if (t == "Float64") return as<double>(bytes);
        if (t == "Int32" || t == "UInt32") return as<std::int32_t>(bytes);
        if (t == "Int64" || t == "UInt64") return as<std::int64_t>(bytes);
        fail(fmt::format("has values of type '{}', which are not read here", t));
    }

    template <typename T>
    static std::vector<double> as(const std::string& bytes) {
        std::vector<double> values(bytes.size() / sizeof(T));
        for (std::size_t i = 0; i < values.size(); ++i) {
            T value{};
            std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
            values[i] = static_cast<double>(value);
        }
        return values;
    }

    /// The first `count` bytes of `data`, which go on behind what was taken.
    std::string take(std::string_view& data, std::size_t count, bool is_base64) const {
        const std::size_t size = is_base64 ? (count + 2) / 3 * 4 : count;
        if (count > data.size() || size > data.size()) fail("its data end too early");
        std::string bytes(data.substr(0, size));
        data.remove_prefix(size);
        if (is_base64) bytes = from_base64(bytes).substr(0, count);
        if (bytes.size() < count) fail("its data end too early");  // Some were no digits.
        return bytes;
    }

    std::uint64_t number(const std::string& bytes, std::size_t index) const {
        std::uint64_t value = 0;
        std::memcpy(&value, bytes.data() + index * header_bytes_, header_bytes_);
        return value;
    }

    /// Values behind their lengths: of all, or of compressed blocks, whose lengths stand apart.
    std::string block(std::string_view data, bool is_base64) const {
        std::string_view peek = data;
        const std::uint64_t count = number(take(peek, header_bytes_, is_base64), 0);
        if (!is_compressed_) {
            if (count > data.size()) fail("its data end too early");
            return take(data, header_bytes_ + count, is_base64).substr(header_bytes_);
        }
        if (count > data.size()) fail("its blocks are broken");
        const std::string lengths = take(data, (3 + count) * header_bytes_, is_base64);
        std::uint64_t all = 0;
        for (std::size_t i = 0; i < count; ++i) {
            all += std::min<std::uint64_t>(number(lengths, 3 + i), max_export_count);
        }
        const std::string packed = take(data, all, is_base64);
        std::string out;
        std::size_t at = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint64_t last = number(lengths, 2);
            uLongf size = i + 1 == count && last != 0 ? last : number(lengths, 1);
            const std::uint64_t bytes = number(lengths, 3 + i);
            // Checked before allocation, so that a small file cannot claim gigabytes.
            if (bytes > packed.size() - at || size / max_zlib_ratio > bytes) {
                fail("its blocks are broken");
            }
            const std::size_t before = out.size();
            out.resize(before + size);
            if (uncompress(reinterpret_cast<Bytef*>(out.data() + before), &size,
                           reinterpret_cast<const Bytef*>(packed.data() + at), bytes) != Z_OK) {
                fail("its compressed data are damaged");
            }
            at += bytes;
        }
        return out;
    }

    const std::string& path_;
    std::string_view bytes_, appended_;
    std::size_t at_ = 0;  ///< In bytes_.
    bool is_compressed_ = false, is_base64_ = false;
    std::size_t header_bytes_ = 4;
    MeshFile out_;
};

}  // namespace

MeshFile read_vtp(const std::string& path, std::string_view bytes) {
    return VtpFile(path, bytes).run();
}

}  // namespace pxpl5::host::io
