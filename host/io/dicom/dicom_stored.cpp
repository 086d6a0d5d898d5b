// Slices of a series as values that GPs read from their files.
#include <fmt/format.h>

#include <algorithm>

#include "host/io/dicom/dicom_series.hpp"
#include "host/io/values/header_text.hpp"

namespace pxpl5::host::io {

namespace {

std::string file_name(const DicomSlice& slice) {
    return shown(slice.path.filename().string());
}

/// "12 of 16 bits, signed".
std::string bits_text(const DicomSlice& slice) {
    return fmt::format("{} of {} bits, {}", slice.bits_stored, slice.bits,
                       slice.is_signed ? "signed" : "unsigned");
}

Component component_of(const DicomSlice& slice) {
    switch (slice.bits) {
        case 8:
            return slice.is_signed ? Component::int8 : Component::uint8;
        case 16:
            return slice.is_signed ? Component::int16 : Component::uint16;
        default:
            return slice.is_signed ? Component::int32 : Component::uint32;
    }
}

std::uint64_t frame_bytes(const DicomSlice& slice) {
    return static_cast<std::uint64_t>(slice.columns) * static_cast<std::uint64_t>(slice.rows) *
           static_cast<std::uint64_t>(slice.bits) / 8;
}

}  // namespace

std::string why_not_by_gps(const std::vector<DicomSlice>& slices) {
    const DicomSlice& first = slices.front();
    for (const DicomSlice& slice : slices) {
        if (slice.unpacked) {
            return fmt::format("{} lies in an archive", file_name(slice));
        }
        if (!slice.is_gray()) {
            return fmt::format("{} has color", file_name(slice));
        }
        if (slice.tiles_across > 1) {
            return fmt::format("{} has its slices side by side, as a mosaic", file_name(slice));
        }
        if (!slice.raw_offset_bytes) {
            return fmt::format("{} is compressed, deflated, big endian, or cut", file_name(slice));
        }
        if (slice.bits != first.bits || slice.bits_stored != first.bits_stored ||
            slice.is_signed != first.is_signed) {
            return fmt::format("its slices have values of several types: {} has {}, {} has {}",
                               file_name(first), bits_text(first), file_name(slice),
                               bits_text(slice));
        }
    }
    return "";
}

StoredVolume stored_volume_of(const std::vector<DicomSlice>& slices) {
    const DicomSlice& first = slices.front();
    StoredVolume stored{component_of(first), false, first.bits_stored, {}};
    for (const DicomSlice& slice : slices) {
        const std::string path = std::filesystem::absolute(slice.path).string();
        const std::uint64_t offset =
            *slice.raw_offset_bytes + static_cast<std::uint64_t>(slice.frame) * frame_bytes(slice);
        if (!stored.files.empty()) {  // The next frame of the same file?
            SlicesFile& last = stored.files.back();
            if (last.path == path && last.scale == slice.scale &&
                offset == last.offset_bytes + last.slices * frame_bytes(slice)) {
                ++last.slices;
                continue;
            }
        }
        stored.files.push_back({path, offset, 1, slice.scale, slice.facts});
    }
    return stored;
}

}  // namespace pxpl5::host::io
