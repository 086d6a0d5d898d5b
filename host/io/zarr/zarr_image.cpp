#include "host/io/zarr/zarr_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "host/io/formats/stored_header.hpp"
#include "host/io/values/component.hpp"
#include "host/io/values/frames.hpp"
#include "host/io/values/header_text.hpp"
#include "host/io/values/place.hpp"
#include "host/io/values/value_sink.hpp"
#include "host/io/zarr/zarr_chunks.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t max_chunks = 1'000'000;
constexpr std::uint64_t max_decoded_bytes = std::uint64_t{64} << 30;

/// Time and place of the volume, from the axes.
void take_axes(const ZarrImage& image, const ZarrLevel& level, const ImportRequest& request,
               Volume& volume) {
    const std::vector<ZarrAxis>& axes = level.axes;
    std::string without_unit;
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        const std::string& name = axes[axis].name;
        const std::size_t at = std::string_view("xyz").find(name);
        if (name == "c" && level.array.shape[axis] > 1) {
            throw ImportError(
                fmt::format("{}: has {} channels, a volume has 1: write the wanted "
                            "one to an image of its own",
                            image.root.string(), level.array.shape[axis]));
        }
        if (name == "t") {
            check_frame(image.root.string(), "image", request.frame, level.array.shape[axis]);
            volume.frames = static_cast<int>(level.array.shape[axis]);
            volume.frame = static_cast<int>(std::max<std::uint32_t>(request.frame, 1));
            const double step_ms = level.scale[axis] * axes[axis].unit;
            volume.frame_ms =
                volume.frames > 1 && step_ms > 0 && step_ms <= max_frame_ms ? step_ms : 0;
        }
        if (at == std::string_view::npos) {
            continue;
        }
        const double unit = axes[axis].unit == 0 || !level.has_scale ? 1 : axes[axis].unit;
        const auto column = static_cast<int>(at);
        without_unit += axes[axis].unit == 0 && level.has_scale ? name : "";
        volume.voxel_to_patient[column] *= level.scale[axis] * unit;
        volume.voxel_to_patient[3][column] = level.shift[axis] * unit;
    }
    if (volume.frames == 1) {
        check_frame(image.root.string(), "image", request.frame, 1);
    } else {
        volume.findings.push_back(
            {FindingKind::note,
             fmt::format("volume {} of {} of a time series", volume.frame, volume.frames)});
    }
    if (!without_unit.empty()) {
        volume.findings.push_back(
            {FindingKind::assumption,
             fmt::format("{} states no unit of {}: millimeters are assumed",
                         image.root.filename().string(), fmt::join(without_unit, ", "))});
    }
}

}  // namespace

bool is_zarr(const fs::path& path) {
    std::error_code failure;
    return fs::is_regular_file(path / ".zarray", failure) ||
           fs::is_regular_file(path / ".zattrs", failure) ||
           fs::is_regular_file(path / ".zgroup", failure) ||
           fs::is_regular_file(path / "zarr.json", failure);
}

fs::path zarr_root(const fs::path& path) {
    fs::path folder = fs::absolute(path).lexically_normal();
    folder = folder.has_filename() ? folder : folder.parent_path();
    std::error_code failure;
    return fs::is_regular_file(folder / ".zarray", failure) ? folder.parent_path() : folder;
}

Volume read_zarr(const fs::path& path, const ImportRequest& request) {
    const std::string source = path.string();
    const std::optional<ZarrImage> image = zarr_image_at(zarr_root(path));
    if (!image) {
        std::error_code failure;
        throw ImportError(
            fs::is_regular_file(path / "zarr.json", failure)
                ? source + ": is of Zarr 3 (zarr.json); OME-Zarr 0.1 to 0.4, of Zarr 2, is read"
                : source + ": is no image of OME-Zarr: its .zattrs has no multiscales");
    }
    const ZarrLevel level = zarr_level_for(*image, path, request.allowed);
    const auto sizes = level.sizes();
    const std::array<int, 3> dims = volume_dims(source, {sizes[0], sizes[1], sizes[2]});
    Volume volume;
    volume.nx = dims[0];
    volume.ny = dims[1];
    volume.nz = dims[2];
    const std::uint64_t values = sizes[0] * sizes[1] * sizes[2];
    const char* type = component_name(level.array.component);
    check_volume_bytes(source, fmt::format("{}x{}x{} of {}", dims[0], dims[1], dims[2], type),
                       values * component_bytes(level.array.component));
    take_axes(*image, level, request, volume);
    if (level.count > 1) {
        volume.findings.push_back(
            {FindingKind::note,
             fmt::format("level {} of {} ({})", level.number, level.count,
                         level.array.folder.lexically_relative(image->root).string())});
    }
    ZarrChunks chunks(level, static_cast<std::uint64_t>(volume.frame) - 1, request.allowed);
    const std::uint64_t chunk_bytes = level.array.chunk_bytes();
    if (chunks.count() > max_chunks || chunks.count() > max_decoded_bytes / chunk_bytes) {
        throw ImportError(
            fmt::format("{}: has {} chunks of {} bytes, must have at most {}, and {} "
                        "bytes in all",
                        source, chunks.count(), chunk_bytes, max_chunks, max_decoded_bytes));
    }
    // A description without values could ask for any memory.
    const std::uint64_t missing = chunks.count() - chunks.files();
    if (missing == chunks.count()) {
        throw ImportError(fmt::format("{}: none of its {} chunks has a file, for example {}",
                                      source, missing, chunks.first_file().string()));
    }
    if (missing > 0) {
        volume.findings.push_back(
            {FindingKind::note, fmt::format("{} of {} chunks have no file: their voxels are {}",
                                            missing, chunks.count(), level.array.fill_text)});
    }
    ValueSink sink(values);
    chunks.read(sink);
    sink.finish(source, volume);
    take_directions(source, request,
                    "OME-Zarr states no patient space: x, y, z are taken as left, posterior, "
                    "superior",
                    volume);
    const bool stated = level.has_scale;  // From version 0.4 on.
    take_spacing(source, request, {stated, stated, stated}, volume);
    return volume;
}

}  // namespace pxpl5::host::io
