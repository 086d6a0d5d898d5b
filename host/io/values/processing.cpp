#include "host/io/values/processing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "host/io/values/scalar_types.hpp"

namespace pxpl5::host::io {

namespace {

constexpr double whole_rounding = 1e-9;  // Share of a voxel: 2.9999999999 voxels are 3.

using Sizes = std::array<std::uint32_t, 3>;

Sizes sizes_of(const Volume& volume) {
    return {static_cast<std::uint32_t>(volume.nx), static_cast<std::uint32_t>(volume.ny),
            static_cast<std::uint32_t>(volume.nz)};
}

std::string text_of(const Sizes& sizes) {
    return fmt::format("{}x{}x{}", sizes[0], sizes[1], sizes[2]);
}

void report(Volume& volume, std::string text) {
    volume.findings.push_back({FindingKind::processed, std::move(text)});
}

/// From the first to the last voxel, in voxels or units of slice_places.
double extent(const Volume& volume, std::size_t axis) {
    return axis == 2 && !volume.slice_places.empty()
               ? volume.slice_places.back()
               : static_cast<double>(sizes_of(volume)[axis]) - 1;
}

double step_mm(const Volume& volume, std::size_t axis) {
    return glm::length(glm::dvec3(volume.voxel_to_patient[static_cast<int>(axis)]));
}

/// The places of slices first .. first + count - 1, from 0 on.
void crop_places(std::size_t first, std::size_t count, Volume& volume) {
    std::vector<int> gaps;
    for (const int slab : volume.gap_slabs) {
        const int moved = slab - static_cast<int>(first);
        if (moved >= 0 && moved + 1 < static_cast<int>(count)) {
            gaps.push_back(moved);
        }
    }
    volume.gap_slabs = std::move(gaps);
    if (volume.slice_places.empty()) {
        return;
    }
    std::vector<double> places(
        volume.slice_places.begin() + static_cast<std::ptrdiff_t>(first),
        volume.slice_places.begin() + static_cast<std::ptrdiff_t>(first + count));
    const double begin = places.front();
    for (double& place : places) {
        place -= begin;
    }
    volume.slice_places = count > 1 ? places : std::vector<double>{};
}

void take_range(Volume& volume) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    with_scalar(volume.type, [&]<typename T>(T*) {
        for (const T value : typed<T>(std::span<const std::byte>(volume.values))) {
            const auto number = static_cast<double>(value);
            if (std::isfinite(number)) {
                low = std::min(low, number);
                high = std::max(high, number);
            }
        }
    });
    volume.minimum = low;
    volume.maximum = high;
}

void check_finite(const std::string& file, const Volume& volume) {
    if (!std::isfinite(volume.minimum)) {
        throw ImportError(fmt::format("{}: none of the values that are left in {} voxels is finite",
                                      file, text_of(sizes_of(volume))));
    }
}

NewAxis new_axis(const std::string& file, const ImportRequest& request, const Volume& volume,
                 std::size_t axis) {
    const double old_extent = extent(volume, axis);
    const char name = "xyz"[axis];
    const int least = old_extent == 0 ? 1 : 2;
    if (request.resample_size) {
        const std::uint32_t size = (*request.resample_size)[axis];
        if (size < static_cast<std::uint32_t>(least) || size > max_volume_voxels ||
            (least == 1 && size != 1)) {
            throw ImportError(fmt::format(
                "{}: {} voxels along {} are asked for, must be {} to {} (it has {})", file, size,
                name, least, least == 1 ? 1 : max_volume_voxels, sizes_of(volume)[axis]));
        }
        return {static_cast<int>(size), size == 1 ? 1 : old_extent / (size - 1)};
    }
    const double spacing = (*request.resample_spacing_mm)[static_cast<int>(axis)];
    const double length_mm = old_extent * step_mm(volume, axis);
    const double steps = std::floor(length_mm / spacing + whole_rounding);
    if (!std::isfinite(spacing) || !(spacing > 0) || steps + 1 < least ||
        steps + 1 > max_volume_voxels) {
        throw ImportError(fmt::format(
            "{}: voxels every {} mm along {} are asked for, its {:.3f} mm would hold {}, must be "
            "{} to {}",
            file, spacing, name, length_mm, steps + 1, least, max_volume_voxels));
    }
    return {static_cast<int>(steps) + 1, spacing / step_mm(volume, axis)};
}

void resample_as_asked(const ImportRequest& request, Volume& volume) {
    const std::string& file = request.path;
    if (request.resample_size && request.resample_spacing_mm) {
        throw ImportError(
            fmt::format("{}: a size ({}) and a spacing ({} mm along x) are asked "
                        "for: give one of them",
                        file, text_of(*request.resample_size), request.resample_spacing_mm->x));
    }
    const Sizes before = sizes_of(volume);
    std::array<NewAxis, 3> axes;
    std::uint64_t bytes = size_bytes(volume.type);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        axes[axis] = new_axis(file, request, volume, axis);
        bytes *= static_cast<std::uint64_t>(axes[axis].size);
    }
    if (bytes > max_volume_bytes) {
        throw ImportError(fmt::format("{}: {}x{}x{} voxels need {} bytes, at most {} are made",
                                      file, axes[0].size, axes[1].size, axes[2].size, bytes,
                                      max_volume_bytes));
    }
    const bool was_uneven = !volume.slice_places.empty();
    resample(axes, volume);
    report(volume,
           fmt::format("resampled from {} to {} voxels, trilinear, over the same extent of voxel "
                       "centers: {:.4g} x {:.4g} x {:.4g} mm apart{}",
                       text_of(before), text_of(sizes_of(volume)), step_mm(volume, 0),
                       step_mm(volume, 1), step_mm(volume, 2),
                       was_uneven ? "; uneven slices have become even" : ""));
}

/// Findings on the slices of the whole file, some of which the crop may have left out.
void date_slice_findings(Volume& volume) {
    for (Finding& finding : volume.findings) {
        if (finding.kind == FindingKind::missing_slices ||
            finding.kind == FindingKind::uneven_slices) {
            finding.text = "before cropping, " + finding.text;
        }
    }
}

void crop_as_asked(const ImportRequest& request, Volume& volume) {
    if (!request.crop_first || !request.crop_size) {
        throw ImportError(request.path + ": a crop needs a first voxel and a size");
    }
    const Sizes before = sizes_of(volume);
    const std::size_t gaps_before = volume.gap_slabs.size();
    crop(request.path, *request.crop_first, *request.crop_size, volume);
    if (volume.nz < static_cast<int>(before[2])) {
        date_slice_findings(volume);
    }
    if (const std::size_t gaps = volume.gap_slabs.size(); gaps < gaps_before) {
        report(volume, fmt::format("the crop leaves out {} of {} gaps of missing slices",
                                   gaps_before - gaps, gaps_before));
    }
    report(volume,
           fmt::format("cropped to {} voxels from voxel {},{},{} of {}",
                       text_of(*request.crop_size), (*request.crop_first)[0],
                       (*request.crop_first)[1], (*request.crop_first)[2], text_of(before)));
}

}  // namespace

void crop(const std::string& file, const Sizes& first, const Sizes& size, Volume& volume) {
    const Sizes old = sizes_of(volume);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::uint32_t least = axis < 2 ? min_volume_voxels : 1;
        if (size[axis] < least || std::uint64_t{first[axis]} + size[axis] > old[axis]) {
            throw ImportError(fmt::format(
                "{}: a crop of {} voxels from {} on along {} is asked for, it has {} and at least "
                "{} must be left",
                file, size[axis], first[axis], "xyz"[axis], old[axis], least));
        }
    }
    const std::size_t bytes = size_bytes(volume.type), row = size[0] * bytes;
    std::size_t to = 0;
    for (std::size_t z = first[2]; z < std::size_t{first[2]} + size[2]; ++z) {
        for (std::size_t y = first[1]; y < std::size_t{first[1]} + size[1]; ++y) {
            const std::size_t from = ((z * old[1] + y) * old[0] + first[0]) * bytes;
            std::memmove(volume.values.data() + to, volume.values.data() + from, row);
            to += row;
        }
    }
    volume.values.resize(to);
    volume.values.shrink_to_fit();
    const double z_place = volume.slice_places.empty() ? first[2] : volume.slice_places[first[2]];
    volume.voxel_to_patient[3] =
        volume.voxel_to_patient * glm::dvec4(first[0], first[1], z_place, 1);
    volume.nx = static_cast<int>(size[0]);
    volume.ny = static_cast<int>(size[1]);
    volume.nz = static_cast<int>(size[2]);
    crop_places(first[2], size[2], volume);
}

void process_volume(const ImportRequest& request, Volume& volume) {
    const bool crops = request.crop_first || request.crop_size;
    const bool smooths = request.smooth_mm != 0;
    const bool resamples = request.resample_size || request.resample_spacing_mm;
    if (crops) {
        crop_as_asked(request, volume);
    }
    if (smooths) {
        if (!(request.smooth_mm > 0) || !(request.smooth_mm <= max_smooth_mm)) {
            throw ImportError(
                fmt::format("{}: smoothing by {} mm is asked for, must be above 0 to "
                            "{}",
                            request.path, request.smooth_mm, max_smooth_mm));
        }
        smooth(request.smooth_mm, volume);
        report(volume, fmt::format("smoothed by a Gaussian of {} mm (standard deviation)",
                                   request.smooth_mm));
    }
    if (resamples) {
        resample_as_asked(request, volume);
    }
    if (crops || smooths || resamples) {
        take_range(volume);
        check_finite(request.path, volume);
        volume.digest = 0;
    }
}

}  // namespace pxpl5::host::io
