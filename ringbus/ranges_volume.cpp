#include <fmt/core.h>

#include "ringbus/range_check.hpp"
#include "ringbus/ranges.hpp"

namespace pxpl5::bus {

namespace {

constexpr std::uint64_t least_reduced_bytes = 4096, most_reduced_bytes = std::uint64_t{1} << 40;

/// Three positive numbers, or none.
template <typename Vector, typename Low, typename High>
void check_triple(Check& check, const char* field, const Vector* values, Low low, High high) {
    if (values == nullptr) {
        return;
    }
    check.equal(field, std::size_t{values->size()}, std::size_t{3});
    for (const auto value : *values) {
        check.within(field, value, low, high);
    }
}

std::string range_of(const schema::ImportVolume& import) {
    Check check;
    check_triple(check, "spacing_mm", import.spacing_mm(), min_spacing_mm, max_spacing_mm);
    check_triple(check, "crop_first", import.crop_first(), 0, max_volume_voxels);
    check_triple(check, "crop_size", import.crop_size(), 1, max_volume_voxels);
    check_triple(check, "resample_size", import.resample_size(), 1, max_volume_voxels);
    check_triple(check, "resample_spacing_mm", import.resample_spacing_mm(), min_spacing_mm,
                 max_spacing_mm);
    check_triple(check, "origin_mm", import.origin_mm(), -double{max_scene_mm},
                 double{max_scene_mm});
    check.within("smooth_mm", import.smooth_mm(), 0.0, max_smooth_mm)
        .equal("crop_first and crop_size together", import.crop_first() == nullptr,
               import.crop_size() == nullptr);
    if (const schema::RawLayout* raw = import.raw()) {
        check.within("nx", raw->nx(), 1, max_volume_voxels)
            .within("ny", raw->ny(), 1, max_volume_voxels)
            .within("nz", raw->nz(), 1, max_volume_voxels);
    }
    check.known("read", import.read())
        .known("gradient", import.gradient())
        .within("volumes", import.volumes(), 1, max_frames)
        .within("reduced_bytes", import.reduced_bytes(), least_reduced_bytes, most_reduced_bytes);
    return check.reason();
}

void check_slices(Check& check, const schema::VolumeHeader& header) {
    if (const auto* places = header.slice_places()) {
        check.equal("number of slice_places", std::uint32_t{places->size()}, header.nz());
        for (flatbuffers::uoffset_t i = 0; i < places->size(); ++i) {
            check.within("slice_places", places->Get(i), -1e6, 1e6);
            if (i > 0 && !(places->Get(i) > places->Get(i - 1))) {
                check.add(fmt::format("slice_places {} is {}, after {}", i, places->Get(i),
                                      places->Get(i - 1)));
            }
        }
    }
    for (std::size_t i = 0; i < size_of(header.gap_slabs()); ++i) {
        const auto at = static_cast<flatbuffers::uoffset_t>(i);
        check.within("gap_slabs", header.gap_slabs()->Get(at),
                     i == 0 ? 0U : header.gap_slabs()->Get(at - 1) + 1, max_slab);
    }
}

void check_times(Check& check, const schema::VolumeHeader& header) {
    const auto* times = header.times_ms();
    if (times == nullptr || times->size() == 0) {
        return;
    }
    check.equal("number of times_ms", std::uint32_t{times->size()}, header.frames())
        .within("number of times_ms", times->size(), 2, max_frames)
        .equal("frame_ms beside times_ms", header.frame_ms(), 0.0)
        .equal("times_ms 0", times->Get(0), 0.0);
    for (flatbuffers::uoffset_t i = 1; i < times->size(); ++i) {
        check.within("times_ms", times->Get(i), 0.0, max_frame_ms);
        if (!(times->Get(i) > times->Get(i - 1))) {
            check.add(
                fmt::format("times_ms {} is {}, after {}", i, times->Get(i), times->Get(i - 1)));
        }
    }
}

/// A single slice has a place, though no surface: Graphics Processors refuse it.
std::string range_of(const schema::VolumeHeader& header, Elements elements) {
    Check check;
    check.within("nx", header.nx(), min_volume_voxels, max_volume_voxels)
        .within("ny", header.ny(), min_volume_voxels, max_volume_voxels)
        .within("nz", header.nz(), 1, max_volume_voxels)
        .known("type", header.type())
        .finite("voxel_to_patient", *header.voxel_to_patient())
        .finite("minimum", header.minimum())
        .finite("maximum", header.maximum())
        .at_most("minimum", header.minimum(), header.maximum())
        .known("gradient", header.gradient())
        .within("slabs_per_set", header.slabs_per_set(), 1, max_volume_voxels)
        .length("suv_per_value", header.suv_per_value())
        .within("frames", header.frames(), 1, max_frames)
        .within("frame", header.frame(), 1, header.frames())
        .within("frame_ms", header.frame_ms(), 0.0, max_frame_ms);
    check_slices(check, header);
    check_times(check, header);
    check.add(files_out_of_range(header, elements));
    if (header.windows() != nullptr) {
        check.at_most("number of windows", header.windows()->size(), std::uint32_t{max_windows});
        for (const auto* window : *header.windows()) {
            check.within("width of a window", window->width(), least_window, most_window)
                .within("level of a window", window->level(), -most_window, most_window);
            if (!elements.take(check, window->name()->size())) {
                break;
            }
        }
    }
    if (header.findings() != nullptr) {
        for (const auto* finding : *header.findings()) {
            check.known("kind of finding", finding->kind());
            if (!elements.take(check, finding->text()->size())) {
                break;  // The host copies each text.
            }
        }
    }
    return check.reason();
}

std::string range_of(const schema::Slices& slices) {
    const std::uint32_t count = slices.slice_count();
    Check check;
    check.within("slice_count", count, 1, max_volume_voxels);
    if (!check.reason().empty()) {
        return check.reason();  // What follows divides by it and subtracts it.
    }
    return check.within("first_slice", slices.first_slice(), 0, max_volume_voxels - count)
        .equal("bytes beyond whole slices", slices.values()->size() % count, 0U)
        .reason();
}

std::string range_of(const schema::FetchVoxels& fetch) {
    const schema::VoxelBox& box = *fetch.box();
    Check check;
    const auto along = [&check](const char* first, std::uint32_t from, const char* size,
                                std::uint32_t count) {
        check.within(first, from, 0, max_volume_voxels - 1);
        if (check.reason().empty()) {
            check.within(size, count, 1, max_volume_voxels - from);
        }
    };
    along("x", box.x(), "nx", box.nx());
    along("y", box.y(), "ny", box.ny());
    along("z", box.z(), "nz", box.nz());
    return check.reason();
}

std::string range_of(const schema::VoxelValues& found) {
    const auto& slices = *found.slices();
    Check check;
    check.within("number of slices", slices.size(), 0, max_volume_voxels);
    for (flatbuffers::uoffset_t i = 0; check.reason().empty() && i < slices.size(); ++i) {
        check.within("slice", slices.Get(i), i == 0 ? 0U : slices.Get(i - 1) + 1,
                     max_volume_voxels - 1);
    }
    return check
        .equal("bytes beyond whole slices",
               slices.size() == 0 ? found.values()->size() : found.values()->size() % slices.size(),
               0U)
        .reason();
}

}  // namespace

std::string volume_out_of_range(const schema::Message& message, std::size_t body_bytes) {
    switch (message.body_type()) {
        case Body::ImportVolume:
            return range_of(*message.body_as_ImportVolume());
        case Body::VolumeHeader:
            return range_of(*message.body_as_VolumeHeader(), Elements(body_bytes));
        case Body::Slices:
            return range_of(*message.body_as_Slices());
        case Body::FetchVoxels:
            return range_of(*message.body_as_FetchVoxels());
        case Body::VoxelValues:
            return range_of(*message.body_as_VoxelValues());
        default:
            return {};  // The others hold nothing that could be out of range.
    }
}

}  // namespace pxpl5::bus
