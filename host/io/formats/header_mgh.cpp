// MGH and MGZ, the volumes of FreeSurfer.
// Source: FreeSurfer's page "The MGH/MGZ Volume Format", surfer.nmr.mgh.harvard.edu/fswiki.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/mat3x3.hpp>

#include "host/io/formats/header_bytes.hpp"
#include "host/io/formats/stored_header.hpp"
#include "host/io/values/place.hpp"

namespace pxpl5::host::io {

namespace {

constexpr std::size_t mgh_header_bytes = 284;  // The values follow; behind them may be tags.

struct MghType {
    std::int32_t code;
    Component component;
};
constexpr std::array mgh_types = {MghType{0, Component::uint8}, MghType{1, Component::int32},
                                  MghType{3, Component::float32}, MghType{4, Component::int16},
                                  MghType{10, Component::uint16}};

void read_mgh_sizes(const std::string& file, const HeaderBytes& raw, StoredHeader& header) {
    constexpr std::array names = {"width", "height", "depth", "nframes"};
    for (std::size_t axis = 0; axis < names.size(); ++axis) {
        const auto size = raw.at<std::int32_t>(4 + 4 * axis);
        if (size < 1) {
            throw ImportError(
                fmt::format("{}: {} is {}, must be 1 or more", file, names[axis], size));
        }
        header.sizes.push_back(static_cast<std::uint64_t>(size));
    }
    drop_single_frame(header);
}

void read_mgh_type(const std::string& file, const HeaderBytes& raw, StoredHeader& header) {
    const auto code = raw.at<std::int32_t>(20);
    const auto* type = std::ranges::find(mgh_types, code, &MghType::code);
    if (type == mgh_types.end()) {
        throw ImportError(fmt::format(
            "{}: type is {}, must be 0 (uchar), 1 (int), 3 (float), 4 (short) or 10 (ushort)", file,
            code));
    }
    header.component = type->component;
    header.type = component_name(type->component);
}

/// The header has the place of the middle of the volume: half of each size in voxels from the first
/// voxel.
void read_mgh_place(const HeaderBytes& raw, StoredHeader& header) {
    std::array<double, 3> spacing{1, 1, 1};
    // FreeSurfer's own assumption: coronal slices.
    std::array<double, 12> ras{-1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 0, 0};
    if (raw.at<std::int16_t>(28) > 0) {
        raw.copy<float>(30, spacing);
        raw.copy<float>(42, ras);
    } else {
        header.spacing_stated.fill(false);
        header.assumed_directions =
            "goodRASFlag is 0: x, y, z are taken as left, inferior, anterior, as FreeSurfer does; "
            "left and right may be swapped";
    }
    glm::dmat4 place(1.0);
    glm::dvec3 middle(0.0);
    for (int axis = 0; axis < 4; ++axis) {
        const auto at = 3 * static_cast<std::size_t>(axis);
        place[axis] = glm::dvec4(ras[at], ras[at + 1], ras[at + 2], axis < 3 ? 0 : 1);
    }
    for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        place[axis] *= spacing[at];
        middle[axis] = static_cast<double>(header.sizes[at]) / 2;
    }
    if (header.assumed_directions.empty()) {
        place[3] -= glm::dvec4(glm::dmat3(place) * middle, 0);
    }  // Else the first voxel is at the origin, as in other files without a place.
    header.voxel_to_patient = to_lps(place);
}

}  // namespace

StoredHeader read_mgh_header(const std::filesystem::path& path, std::uint32_t frame) {
    const std::string file = path.string();
    HeaderBytes raw = read_header_bytes(path, mgh_header_bytes, mgh_header_bytes);
    raw.big_endian = true;  // By definition of the format.
    if (const auto version = raw.at<std::int32_t>(0); version != 1) {
        throw ImportError(fmt::format("{}: version is {}, must be 1", file, version));
    }
    StoredHeader header;
    read_mgh_sizes(file, raw, header);
    read_mgh_type(file, raw, header);
    take_frames(file, frame, FourthAxis::time, header);
    read_mgh_place(raw, header);
    header.big_endian = true;
    header.encoding = raw.encoding;
    header.data_files = {path};
    header.byte_skip = mgh_header_bytes;
    check_stored_header(path, header);
    return header;
}

}  // namespace pxpl5::host::io
