// GIPL, the format of Guy's Image Processing Lab. Its documentation is lost. The fields are those
// that the readers of ITK (itk::GiplImageIO) and of IRTK (irtkGIPL.h) agree on.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/io/formats/header_bytes.hpp"
#include "host/io/formats/stored_header.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t gipl_header_bytes = 256;  // The values follow.
constexpr std::array<std::uint32_t, 2> magic_numbers = {719'555'000, 4'026'526'128};

struct GiplType {
    std::uint16_t code;
    Component component;
};
constexpr std::array gipl_types = {
    GiplType{1, Component::uint8},   GiplType{7, Component::int8},
    GiplType{8, Component::uint8},   GiplType{15, Component::int16},
    GiplType{16, Component::uint16}, GiplType{31, Component::uint32},
    GiplType{32, Component::int32},  GiplType{64, Component::float32},
    GiplType{65, Component::float64}};

void read_gipl_sizes(const HeaderBytes& raw, StoredHeader& header) {
    std::array<std::uint64_t, 4> sizes{};
    raw.copy<std::uint16_t>(0, sizes);
    for (std::size_t axis = 2; axis < sizes.size(); ++axis) {
        sizes[axis] = std::max<std::uint64_t>(sizes[axis], 1);  // Writers of slices put in 0.
    }
    header.sizes.assign(sizes.begin(), sizes.end());
    drop_single_frame(header);
}

void read_gipl_type(const std::string& file, const HeaderBytes& raw, StoredHeader& header) {
    const auto code = raw.at<std::uint16_t>(8);
    const auto* type = std::ranges::find(gipl_types, code, &GiplType::code);
    if (type == gipl_types.end()) {
        throw ImportError(fmt::format(
            "{}: its image type is {}, must be one of the scalar types 1, 7, 8, 15, 16, 31, 32, "
            "64, 65",
            file, code));
    }
    header.component = type->component;
    header.type = component_name(type->component);
}

void read_gipl_place(const std::string& file, const HeaderBytes& raw, StoredHeader& header) {
    std::array<double, 3> spacing{}, origin{};
    raw.copy<float>(10, spacing);
    raw.copy<double>(204, origin);
    for (int axis = 0; axis < 3; ++axis) {
        const double step = spacing[static_cast<std::size_t>(axis)];
        if (!std::isfinite(step) || step < 0) {
            throw ImportError(fmt::format("{}: its spacing along {} is {}, must be above 0 mm",
                                          file, "xyz"[axis], step));
        }
        header.spacing_stated[static_cast<std::size_t>(axis)] = step > 0;
        header.voxel_to_patient[axis] *= step > 0 ? step : 1;
        header.voxel_to_patient[3][axis] = origin[static_cast<std::size_t>(axis)];
    }
    header.assumed_directions =
        "GIPL files have no agreed orientation: x, y, z are taken as left, posterior, superior";
}

}  // namespace

StoredHeader read_gipl_header(const std::filesystem::path& path, std::uint32_t frame) {
    const std::string file = path.string();
    HeaderBytes raw = read_header_bytes(path, gipl_header_bytes, gipl_header_bytes);
    raw.big_endian = true;  // By definition of the format.
    const auto magic = raw.at<std::uint32_t>(252);
    if (std::ranges::find(magic_numbers, magic) == magic_numbers.end()) {
        throw ImportError(fmt::format("{}: its magic number is {}, must be {} or {}", file, magic,
                                      magic_numbers[0], magic_numbers[1]));
    }
    StoredHeader header;
    read_gipl_sizes(raw, header);
    read_gipl_type(file, raw, header);
    take_frames(file, frame, header);
    volume_dims(file, header.sizes);
    read_gipl_place(file, raw, header);
    header.big_endian = true;
    header.encoding = raw.encoding;
    header.data_files = {path};
    header.byte_skip = gipl_header_bytes;
    header.ends_file = true;
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
