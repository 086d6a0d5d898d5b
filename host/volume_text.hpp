// What a volume is, for people and programs.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <string>

#include "host/reply.hpp"
#include "host/volume.hpp"

namespace pxpl5::host {

/// Whether the text has a histogram; the fields have one in any case.
enum class VolumeDetail : std::uint8_t { brief, all };

/// What is known of a volume: shape, spacing, orientation, range, histogram, findings.
Reply describe_volume(const Volume& volume, VolumeDetail detail = VolumeDetail::all);

/// Distance between voxel centres along x, y and z in millimetres.
glm::dvec3 spacing_mm(const Volume& volume);

/// Where the volume's axes point in the patient, nearest first letter per axis: "LPS", "RAS", ...
std::string orientation_letters(const Volume& volume);

}  // namespace pxpl5::host
