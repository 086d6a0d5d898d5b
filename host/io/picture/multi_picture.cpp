#include "host/io/picture/multi_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string_view>
#include <utility>

#include "host/io/picture/picture.hpp"

namespace pxpl5::host::io {

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t marker = 0xff, app0 = 0xe0, app1 = 0xe1, app2 = 0xe2, comment = 0xfe;
constexpr std::size_t start_bytes = 2, marker_bytes = 2, length_bytes = 2;

// Numbers are little endian: "II".
constexpr std::string_view identifier("MPF\0", 4), header("II*\0\x08\0\0\0", 8);
constexpr std::size_t bytes_to_header = marker_bytes + length_bytes + identifier.size();
enum FieldType : std::uint16_t { type_long = 4, rational = 5, undefined = 7, signed_rational = 10 };
enum Tag : std::uint16_t {
    version = 0xb000,
    number_of_images = 0xb001,
    image_entries = 0xb002,
    image_number = 0xb101,
    base_viewpoint = 0xb204,
    convergence_angle = 0xb205,
    base_line_length = 0xb206
};
constexpr std::uint32_t disparity = 0x0002'0002, representative = 0x2000'0000;
constexpr std::uint32_t images = 2, entry_bytes = 16, rational_bytes = 8;
constexpr std::uint32_t field_bytes = 12, count_bytes = 2, link_bytes = 4;
constexpr std::uint32_t micrometers_per_meter = 1'000'000;

/// The bytes of a directory of `fields` fields, without the values outside it.
constexpr std::uint32_t directory_bytes(std::uint32_t fields) {
    return count_bytes + fields * field_bytes + link_bytes;
}

void put16(Bytes& bytes, std::uint32_t value) {
    bytes.push_back(static_cast<std::uint8_t>(value));
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}
void put32(Bytes& bytes, std::uint32_t value) {
    put16(bytes, value & 0xffff);
    put16(bytes, value >> 16);
}
void put_field(Bytes& bytes, Tag tag, FieldType type, std::uint32_t count, std::uint32_t value) {
    put16(bytes, tag);
    put16(bytes, type);
    put32(bytes, count);
    put32(bytes, value);  // Or where the values lie, counted from the header.
}

/// Version 1.0, whose four letters take the place of a value.
void put_version(Bytes& bytes) {
    put_field(bytes, version, undefined, 4, '0' | '1' << 8 | '0' << 16 | '0' << 24);
}

/// Where an image lies.
struct ImagePlace {
    std::uint32_t bytes = 0;
    std::uint32_t from_header = 0;  ///< 0 for the first image.
};

/// The index and, behind it, the entries of both images.
void put_index(Bytes& bytes, const ImagePlace& first, const ImagePlace& second) {
    constexpr std::uint32_t fields = 3;
    const std::uint32_t entries = header.size() + directory_bytes(fields);
    put16(bytes, fields);
    put_version(bytes);
    put_field(bytes, number_of_images, type_long, 1, images);
    put_field(bytes, image_entries, undefined, images * entry_bytes, entries);
    put32(bytes, entries + images * entry_bytes);  // The attributes.
    for (const auto& [place, attribute] :
         {std::pair{first, disparity | representative}, {second, disparity}}) {
        put32(bytes, attribute);
        put32(bytes, place.bytes);
        put32(bytes, place.from_header);
        put32(bytes, 0);  // No other image depends on it.
    }
}

/// The attributes of image `number`, counted from 1. `at` is the place of the directory.
void put_attributes(Bytes& bytes, std::uint32_t at, std::uint32_t number, double baseline_mm) {
    const std::uint32_t fields = number == 1 ? 4 : 5;  // The index has the version already.
    const std::uint32_t values = at + directory_bytes(fields);
    put16(bytes, fields);
    if (number > 1) {
        put_version(bytes);
    }
    put_field(bytes, image_number, type_long, 1, number);
    put_field(bytes, base_viewpoint, type_long, 1, 1);
    put_field(bytes, convergence_angle, signed_rational, 1, values);
    put_field(bytes, base_line_length, rational, 1, values + rational_bytes);
    put32(bytes, 0);  // No directory follows.
    put32(bytes, 0);  // The axes of both eyes are parallel: 0 / 1 degrees.
    put32(bytes, 1);
    put32(bytes, static_cast<std::uint32_t>(std::lround(baseline_mm * 1000)));
    put32(bytes, micrometers_per_meter);
}

/// A segment APP2 up to its header, without its length.
Bytes begun_segment() {
    Bytes segment = {marker, app2, 0, 0};
    std::ranges::copy(identifier, std::back_inserter(segment));
    std::ranges::copy(header, std::back_inserter(segment));
    return segment;
}

void put_length(Bytes& segment) {
    const std::size_t length = segment.size() - marker_bytes;
    segment[marker_bytes] = static_cast<std::uint8_t>(length >> 8);  // Big endian, as in all JPEG.
    segment[marker_bytes + 1] = static_cast<std::uint8_t>(length);
}

Bytes first_segment(const ImagePlace& first, const ImagePlace& second, double baseline_mm) {
    Bytes segment = begun_segment();
    put_index(segment, first, second);
    put_attributes(segment, static_cast<std::uint32_t>(segment.size() - bytes_to_header), 1,
                   baseline_mm);
    put_length(segment);
    return segment;
}

Bytes second_segment(double baseline_mm) {
    Bytes segment = begun_segment();
    put_attributes(segment, header.size(), 2, baseline_mm);
    put_length(segment);
    return segment;
}

/// The place behind the start, the segments APP0 and APP1, and comments before them.
std::size_t place_of_segment(std::span<const std::uint8_t> jpeg) {
    constexpr std::uint8_t start = 0xd8;
    if (jpeg.size() < start_bytes || jpeg[0] != marker || jpeg[1] != start) {
        throw PictureError("the encoder made no JPEG file");
    }
    std::size_t at = start_bytes, place = at;
    while (at + marker_bytes + length_bytes <= jpeg.size() && jpeg[at] == marker &&
           (jpeg[at + 1] == app0 || jpeg[at + 1] == app1 || jpeg[at + 1] == comment)) {
        const bool is_app = jpeg[at + 1] != comment;
        at += marker_bytes + (std::size_t{jpeg[at + 2]} << 8 | jpeg[at + 3]);
        place = is_app ? at : place;
    }
    return std::min(place, jpeg.size());
}

void append_with(Bytes& file, std::span<const std::uint8_t> jpeg, std::size_t place,
                 const Bytes& segment) {
    const auto behind = jpeg.begin() + static_cast<std::ptrdiff_t>(place);
    file.insert(file.end(), jpeg.begin(), behind);
    file.insert(file.end(), segment.begin(), segment.end());
    file.insert(file.end(), behind, jpeg.end());
}

}  // namespace

std::vector<std::uint8_t> multi_picture(const JpegPair& pair, double baseline_mm) {
    constexpr std::size_t margin = 1024;  // More than both segments.
    if (pair.left.size() + pair.right.size() + margin > std::numeric_limits<std::uint32_t>::max()) {
        throw PictureError("both pictures together exceed the 4 GiB of an .mpo file");
    }
    const std::size_t left_place = place_of_segment(pair.left);
    const Bytes behind = second_segment(baseline_mm);
    // The size of the segment does not depend on the numbers in it.
    const std::size_t left_bytes = pair.left.size() + first_segment({}, {}, baseline_mm).size();
    const std::size_t header_place = left_place + bytes_to_header;
    const ImagePlace first{static_cast<std::uint32_t>(left_bytes), 0};
    const ImagePlace second{static_cast<std::uint32_t>(pair.right.size() + behind.size()),
                            static_cast<std::uint32_t>(left_bytes - header_place)};
    Bytes file;
    file.reserve(left_bytes + second.bytes);
    append_with(file, pair.left, left_place, first_segment(first, second, baseline_mm));
    append_with(file, pair.right, place_of_segment(pair.right), behind);
    return file;
}

}  // namespace pxpl5::host::io
