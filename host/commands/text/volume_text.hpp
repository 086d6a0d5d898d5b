// Describes a volume as text and as fields.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <string_view>

#include "host/base/reply.hpp"
#include "host/scene/scene.hpp"
#include "host/surface/atlas/histogram.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Whether the text has a histogram; the fields have one in any case.
enum class VolumeDetail : std::uint8_t { brief, all };

/// Describes a volume: shape, spacing, orientation, range, histogram, findings.
Reply describe_volume(const Volume& volume, VolumeDetail detail = VolumeDetail::all);

/// The warning on every picture of a volume whose place or spacing is assumed; empty for others. It
/// is short, so that it is readable in small pictures.
std::string place_warning(const Volume& volume);

/// "14/30, 390 ms": the volume's place in its time series. Empty without one.
std::string time_place(const Volume& volume);
/// A time to the microsecond: "33.333", "870".
std::string ms_text(double ms);

/// Distance between voxel centers along x, y and z in millimeters.
glm::dvec3 spacing_mm(const Volume& volume);

/// "(1.00, -2.50, 0.00)", and its numbers. Zeros have no sign.
std::string place_text(const glm::dvec3& p_mm);
std::vector<double> place_numbers(const glm::dvec3& p);

/// "z 20": a slice in a picture of surfaces, and the same for programs.
std::string plane_text(const ScenePlane& plane);
Fields plane_fields(const ScenePlane& plane);

/// "gantry tilt", "missing slices", ...
std::string finding_name(FindingKind kind);

/// Where the volume's axes point in the patient, nearest first letter per axis: "LPS", "RAS", ...
std::string orientation_letters(const Volume& volume);

/// Unit vectors of the voxel axes x, y, z in the patient, LPS, to six digits.
std::array<glm::dvec3, 3> direction_cosines(const Volume& volume);

/// A row of blocks for each range of values, 16 at most; the length goes with the logarithm of the
/// count.
/// reduction  Of the volume: 1 if all its voxels are counted.
std::string histogram_text(const Histogram& counted, int reduction);
/// first, width, counts.
Fields histogram_fields(const Histogram& counted);

/// The value that so many of a thousand voxels do not exceed, to a bin's width.
double quantile(const Histogram& counted, int per_mille);

}  // namespace pxpl5::host
