#include "host/io/dicom_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>

#include "host/io/import.hpp"

namespace pxpl5::host::io {

namespace {

namespace fs = std::filesystem;

constexpr double same_position_mm = 1e-3;
constexpr double max_uneven = 0.01;  // Of the usual step: positions are written with few digits.

/// A slice and its place along the series' normal.
struct Placed {
    DicomSlice slice;
    double along_mm = 0;
};

std::vector<fs::path> files_of(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        if (entry.is_regular_file()) {
            files.push_back(entry.path());
        }
        if (files.size() > max_series_files) {
            throw ImportError(
                fmt::format("{}: has more than {} files", folder.string(), max_series_files));
        }
    }
    std::sort(files.begin(), files.end());  // Folders have no order of their own.
    return files;
}

/// Slices of one volume agree in all of this.
std::string series_key(const DicomSlice& slice) {
    const auto rounded = [](glm::dvec3 v) {
        return fmt::format("{:.3f},{:.3f},{:.3f}", v.x + 0.0, v.y + 0.0, v.z + 0.0);
    };
    return fmt::format("{} {}x{}x{} {} {}", slice.series, slice.columns, slice.rows, slice.frames,
                       rounded(slice.x_step_mm), rounded(slice.y_step_mm));
}

/// The slices of the largest group; the first by key if two are equally large.
std::vector<DicomSlice> largest_series(const fs::path& folder, const ReadDicomHeader& read_header,
                                       std::vector<std::string>& notes) {
    std::map<std::string, std::vector<DicomSlice>> series;
    std::size_t other_files = 0;
    for (const fs::path& file : files_of(folder)) {
        if (const std::optional<DicomSlice> slice = read_header(file)) {
            series[series_key(*slice)].push_back(*slice);
        } else {
            ++other_files;
        }
    }
    if (series.empty()) {
        throw ImportError(
            fmt::format("{}: none of its {} files is a DICOM image", folder.string(), other_files));
    }
    const auto largest = std::max_element(
        series.begin(), series.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    if (other_files > 0) {
        notes.push_back(fmt::format("{} files are not DICOM images and are left out", other_files));
    }
    for (const auto& [key, slices] : series) {
        if (key != largest->first) {
            notes.push_back(
                fmt::format("{} slices of {}x{} of another series or orientation are "
                            "left out, the first is {}",
                            slices.size(), slices[0].columns, slices[0].rows,
                            slices[0].path.filename().string()));
        }
    }
    return largest->second;
}

std::vector<Placed> in_order(const std::vector<DicomSlice>& slices, glm::dvec3 normal,
                             std::vector<std::string>& notes) {
    std::vector<Placed> placed;
    for (const DicomSlice& slice : slices) {
        placed.push_back({slice, glm::dot(slice.origin_mm, normal)});
    }
    std::stable_sort(placed.begin(), placed.end(),
                     [](const Placed& a, const Placed& b) { return a.along_mm < b.along_mm; });
    std::vector<Placed> kept;
    for (const Placed& next : placed) {
        if (!kept.empty() && next.along_mm - kept.back().along_mm < same_position_mm) {
            notes.push_back(fmt::format("{} has the position of {} and is left out",
                                        next.slice.path.filename().string(),
                                        kept.back().slice.path.filename().string()));
        } else {
            kept.push_back(next);
        }
    }
    return kept;
}

/// The step from slice to slice: direction of the whole series, length of the median step.
glm::dvec3 slice_step(const std::vector<Placed>& placed, std::vector<std::string>& notes) {
    std::vector<double> steps;
    for (std::size_t index = 1; index < placed.size(); ++index) {
        steps.push_back(placed[index].along_mm - placed[index - 1].along_mm);
    }
    std::vector<double> sorted = steps;
    std::sort(sorted.begin(), sorted.end());
    const double median = sorted[sorted.size() / 2];
    for (std::size_t index = 0; index < steps.size(); ++index) {
        if (std::abs(steps[index] - median) > max_uneven * median) {
            notes.push_back(fmt::format(
                "uneven slices: {:.3f} mm from {} to {}, elsewhere {:.3f} mm; shown as even",
                steps[index], placed[index].slice.path.filename().string(),
                placed[index + 1].slice.path.filename().string(), median));
        }
    }
    const glm::dvec3 whole = placed.back().slice.origin_mm - placed.front().slice.origin_mm;
    const double length = placed.back().along_mm - placed.front().along_mm;
    const bool is_even = sorted.back() - sorted.front() <= 2 * max_uneven * median;
    // Over an even series the mean is the better estimate: each position is rounded.
    return is_even ? whole / static_cast<double>(steps.size()) : whole * (median / length);
}

/// Appends `next`, as float64 if its type is another than that of the slices before it.
void append(Decoded& volume, Decoded&& next) {
    if (volume.dims[2] == 0) {
        volume.component = next.component;
    }
    if (next.component != volume.component) {
        widen_to_float64(volume);
        widen_to_float64(next);
    }
    volume.values.insert(volume.values.end(), next.values.begin(), next.values.end());
    ++volume.dims[2];
}

void check_slices(const fs::path& folder, const std::vector<DicomSlice>& slices) {
    for (const DicomSlice& slice : slices) {
        if (slice.frames != 1) {
            throw ImportError(fmt::format("{}: {} has {} frames: give the file itself",
                                          folder.string(), slice.path.filename().string(),
                                          slice.frames));
        }
        if (!slice.position_stated) {
            throw ImportError(
                fmt::format("{}: {} states no position and orientation (0020,0032 "
                            "and 0020,0037), so the slices have no order",
                            folder.string(), slice.path.filename().string()));
        }
    }
}

}  // namespace

Decoded assemble_series(const fs::path& folder, const ReadDicomHeader& read_header,
                        const DecodeSlice& decode) {
    Decoded volume;
    const std::vector<DicomSlice> slices = largest_series(folder, read_header, volume.notes);
    check_slices(folder, slices);
    const DicomSlice& first = slices.front();
    const glm::dvec3 normal = glm::normalize(glm::cross(first.x_step_mm, first.y_step_mm));
    const std::vector<Placed> placed = in_order(slices, normal, volume.notes);
    if (placed.size() < min_dim) {
        throw ImportError(fmt::format("{}: its largest series has {} slices, must be {} to {}",
                                      folder.string(), placed.size(), min_dim, max_dim));
    }
    const glm::dvec3 z_step_mm = slice_step(placed, volume.notes);
    if (!first.spacing_stated) {
        volume.notes.emplace_back(
            "the slices do not state their pixel spacing (0028,0030): sizes may be wrong");
    }
    volume.dims = {first.columns, first.rows, 0};
    for (const Placed& next : placed) {
        append(volume, decode(next.slice.path));
    }
    volume.voxel_to_patient =
        glm::dmat4(glm::dvec4(first.x_step_mm, 0), glm::dvec4(first.y_step_mm, 0),
                   glm::dvec4(z_step_mm, 0), glm::dvec4(placed.front().slice.origin_mm, 1));
    return volume;
}

}  // namespace pxpl5::host::io
