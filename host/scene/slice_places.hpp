// Between slices as they are counted and where they lie in the grid, where they are unevenly
// spaced; and where voxels lie in the patient.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <span>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Grid z of slice `slice`, which may lie between two, or beyond the first or last: there the
/// spacing of the outermost two goes on.
///
/// places   As Volume::slice_places: ascending, at least 2; empty if slice z lies at z.
double place_of_slice(double slice, std::span<const double> places);

/// The inverse of place_of_slice().
double slice_of_place(double place, std::span<const double> places);

/// Returns the middles of the voxels at the corners of a box, LPS.
/// first, last  Voxels, both included.
std::array<glm::dvec3, 8> corners_mm(const Volume& volume, const glm::ivec3& first,
                                     const glm::ivec3& last);

}  // namespace pxpl5::host
