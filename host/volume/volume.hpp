// A volume in the host's memory.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ringbus/rules/slices_file.hpp"
#include "ringbus/rules/voxels.hpp"

namespace pxpl5::host {

struct Finding {
    FindingKind kind = FindingKind::note;
    std::string text;
    friend bool operator==(const Finding&, const Finding&) = default;
};

/// Values from level - width / 2 (black) to level + width / 2 (white).
struct GrayWindow {
    double width = 1, level = 0;
    friend bool operator==(const GrayWindow&, const GrayWindow&) = default;
};

/// A window of gray values that the file names.
struct NamedWindow {
    std::string name;
    double width = 1, level = 0;
    friend bool operator==(const NamedWindow&, const NamedWindow&) = default;
};

/// Voxels with their place in the patient.
///
/// A voxel (x, y, z) lies at the grid position (x, y, place of slice z). voxel_to_patient maps grid
/// positions to millimeters.
struct Volume {
    std::string name;
    int nx = 0, ny = 0, nz = 0;  ///< Voxels.
    Scalar type = Scalar::int16;
    glm::dmat4 voxel_to_patient{1.0};  ///< Grid position (x, y, z) to millimeters, LPS.
    /// Grid z of each slice, ascending. Empty if slices are evenly spaced: slice z lies at z.
    std::vector<double> slice_places;
    std::vector<int> gap_slabs;        ///< Slabs across missing slices, ascending.
    double minimum = 0, maximum = 0;   ///< Over all voxels.
    std::string modality;              ///< CT, MR, US, ...; empty if the file does not state it.
    std::string unit;                  ///< Unit of the values, as the file states it: Bq/ml, ...
    std::vector<NamedWindow> windows;  ///< Windows of the file, the preferred one first.
    /// Standardized uptake value by body weight (g/ml) of a value of 1; 0 if it is not known.
    double suv_per_value = 0;
    std::string series;         ///< SeriesInstanceUID of DICOM files; else empty.
    int frame = 1, frames = 1;  ///< Number in its time series, from 1, and how many there are.
    /// From one volume of the series to the next; 0 if it is unknown or not always the same.
    double frame_ms = 0;
    /// Time of each volume of the series after the first, ascending from 0. Empty if frame_ms is
    /// known, or the series does not state times.
    std::vector<double> times_ms;
    /// GPs estimate gradients, which become normals, with this kernel.
    GradientKernel gradient = GradientKernel::central;
    std::vector<Finding> findings;  ///< Facts that the user must know.
    int slabs_per_set = 1;          ///< Adjacent slabs that go to one GP; 1 in the paper.
    std::vector<std::byte> values;  ///< nx * ny * nz, x fastest, little endian, of `type`.
    std::string source;             ///< File, folder or phantom:NAME.
    std::uint64_t digest = 0;       ///< FNV-1a over the values; 0 if unknown.
    /// The GPs read the values from these files. Otherwise the host sends the values.
    std::optional<StoredVolume> stored;
    /// Above 1: `values` is empty, and `reduced` has every n-th voxel along each axis, from 0.
    int reduction = 1;
    std::shared_ptr<const Volume> reduced;
};

/// Whether the file does not state the whole position and spacing, so that a part is assumed.
inline bool is_assumed(const Volume& volume) {
    return std::ranges::count(volume.findings, FindingKind::assumption, &Finding::kind) != 0;
}

/// Time of volume `frame` of the series after the first; nothing if the series does not state it.
inline std::optional<double> time_ms(const Volume& volume, int frame) {
    return volume.frame_ms > 0 ? std::optional(volume.frame_ms * (frame - 1))
           : volume.times_ms.empty()
               ? std::nullopt
               : std::optional(volume.times_ms.at(static_cast<std::size_t>(frame) - 1));
}

/// z of the last slice in the grid.
inline double last_place(const Volume& volume) {
    return volume.slice_places.empty() ? volume.nz - 1 : volume.slice_places.back();
}

}  // namespace pxpl5::host
