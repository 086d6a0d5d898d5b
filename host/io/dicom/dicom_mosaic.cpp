// Siemens mosaics: all slices of a volume as tiles of one picture. Their number and normal are in
// the scanner's CSA header.
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <optional>
#include <string_view>

#include "host/io/dicom/dicom_elements.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double min_normal_cosine = 0.999;  // Of the stated normal and the picture's own.

std::optional<std::uint32_t> word_at(std::string_view bytes, std::size_t at) {
    std::uint32_t word = 0;
    if (at + sizeof word > bytes.size()) {
        return std::nullopt;
    }
    std::memcpy(&word, bytes.data() + at, sizeof word);  // Little endian, as this machine.
    return word;
}

/// The texts of field `name` of a CSA header ("SV10"), separated by spaces. Empty if the field is
/// absent or the header is broken before its end.
///
/// Layout: 16 bytes, of which word 2 counts the fields. A field: name (64 bytes), 5 words, of which
/// word 3 counts the items, 1 word. An item: 4 words, of which word 1 is its length, and its bytes
/// up to the next multiple of 4.
std::string csa_text(std::string_view bytes, std::string_view name) {
    constexpr std::size_t head_bytes = 16, name_bytes = 64, field_bytes = 84, item_bytes = 16;
    const std::uint32_t fields = word_at(bytes, 8).value_or(0);
    std::size_t at = head_bytes;
    for (std::uint32_t field = 0; bytes.starts_with("SV10") && field < fields; ++field) {
        const std::optional<std::uint32_t> items = word_at(bytes, at + name_bytes + 12);
        if (!items) {
            break;
        }
        const std::string_view key = bytes.substr(at, name_bytes);
        const bool is_wanted = key.substr(0, key.find('\0')) == name;
        std::string text;
        at += field_bytes;
        for (std::uint32_t item = 0; item < *items; ++item) {
            const std::optional<std::uint32_t> length = word_at(bytes, at + 4);
            const std::uint64_t padded = (std::uint64_t{length.value_or(0)} + 3) / 4 * 4;
            if (!length || at + item_bytes + padded > bytes.size()) {
                return {};
            }
            const std::string_view value = bytes.substr(at + item_bytes, *length);
            text += is_wanted ? std::string(value.substr(0, value.find('\0'))) + " " : "";
            at += item_bytes + padded;
        }
        if (is_wanted) {
            return trimmed(text);
        }
    }
    return {};
}

/// The CSA header of the image; private blocks may stand anywhere in group 0029.
std::string csa_header(const gdcm::DataSet& data) {
    for (std::uint16_t block = 0x10; block <= 0xff; ++block) {
        if (text_of(data, gdcm::Tag(0x29, block)) == "SIEMENS CSA HEADER") {
            return bytes_of(data, gdcm::Tag(0x29, static_cast<std::uint16_t>(block << 8U | 0x10U)));
        }
    }
    return {};
}

/// Number and normal of a mosaic's tiles.
struct Mosaic {
    int slices = 0;
    glm::dvec3 normal{0};
};

[[noreturn]] void refuse(const std::string& file, const std::string& reason) {
    throw ImportError(
        fmt::format("{}: is a Siemens mosaic (0008,0008), whose tiles are slices, but {}: export "
                    "it as one image per slice, or convert it to NIfTI with dcm2niix",
                    file, reason));
}

Mosaic read_mosaic(const std::string& file, const std::string& csa) {
    const auto count =
        numbers(file, "NumberOfImagesInMosaic", csa_text(csa, "NumberOfImagesInMosaic"));
    const auto normal = numbers(file, "SliceNormalVector", csa_text(csa, "SliceNormalVector"));
    if (count.size() != 1 || !(count[0] >= 1) || !(count[0] <= max_slices) || normal.size() != 3) {
        refuse(file, fmt::format("it has no CSA header (0029,1010) that states {}",
                                 count.size() == 1 ? "their normal" : "their number"));
    }
    return {static_cast<int>(count[0]), {normal[0], normal[1], normal[2]}};
}

/// Whether the tiles can be told from each other and placed.
void check_mosaic(const std::string& file, const DicomSlice& whole, const Mosaic& mosaic,
                  int across) {
    if (whole.columns % across != 0 || whole.rows % across != 0 ||
        std::min(whole.columns, whole.rows) / across < min_volume_voxels) {
        refuse(file, fmt::format("{} slices of one size do not fit into {}x{} pixels",
                                 mosaic.slices, whole.columns, whole.rows));
    }
    if (!whole.position_stated || !whole.spacing_stated) {
        refuse(file,
               "it lacks position, orientation or pixel spacing (0020,0032; 0020,0037; "
               "0028,0030)");
    }
    if (!whole.frame_step_mm || !(*whole.frame_step_mm > 0)) {
        refuse(file, "it states no distance between slices (0018,0088)");
    }
    const glm::dvec3 normal = glm::normalize(glm::cross(whole.x_step_mm, whole.y_step_mm));
    const double cosine = glm::dot(normal, mosaic.normal) / glm::length(mosaic.normal);
    if (!(std::abs(cosine) > min_normal_cosine)) {
        refuse(file, fmt::format("its slices' normal meets that of the picture at a cosine of {}",
                                 cosine));
    }
}

}  // namespace

void unfold_mosaic(const std::string& file, const gdcm::DataSet& data,
                   std::vector<DicomSlice>& slices) {
    const std::string csa = csa_header(data);
    const bool is_named = text_of(data, gdcm::Tag(8, 8)).find("MOSAIC") != std::string::npos;
    const std::string count = csa_text(csa, "NumberOfImagesInMosaic");
    if (slices.size() != 1 || (!is_named && (count.empty() || count == "0" || count == "1"))) {
        return;
    }
    const DicomSlice whole = slices.front();
    const Mosaic mosaic = read_mosaic(file, csa);
    const int across = static_cast<int>(std::ceil(std::sqrt(mosaic.slices)));
    check_mosaic(file, whole, mosaic, across);
    const glm::dvec3 normal = glm::normalize(glm::cross(whole.x_step_mm, whole.y_step_mm));
    const double sign = glm::dot(normal, mosaic.normal) < 0 ? -1 : 1;
    DicomSlice tile = whole;
    tile.tiles_across = across;
    tile.columns /= across;
    tile.rows /= across;
    // The position in the file is that of a picture of this size about the tile's center.
    tile.origin_mm += whole.x_step_mm * ((whole.columns - tile.columns) / 2.0) +
                      whole.y_step_mm * ((whole.rows - tile.rows) / 2.0);
    slices.clear();
    for (tile.tile = 0; tile.tile < mosaic.slices; ++tile.tile) {
        slices.push_back(tile);
        tile.origin_mm += normal * (sign * *whole.frame_step_mm);
    }
}

}  // namespace pxpl5::host::io
