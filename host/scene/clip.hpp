// Clip planes: from what a person says, in patient millimeters or voxels, to planes of the patient,
// and from there to a frame's.
//
// A plane is (normal, offset): kept is where normal . p + offset >= 0, as in Scene::clip_planes. A
// frame's planes act on grid positions (see host/volume/volume.hpp). These are an affine image of
// the patient's millimeters, so a plane there is a plane here, also where slices are unevenly
// spaced; slices, counted, are not.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>

namespace pxpl5::host {

/// The plane across one of the patient's axes (LPS).
///
/// towards   L, R (left, right), P, A (posterior, anterior), S, I (superior, inferior): the side
///           that is kept.
/// at_mm     Where, counted that way from the patient's origin: R 20 and L -20 are one place.
/// Returns   Nothing for another letter.
std::optional<glm::dvec4> axis_plane(char towards, double at_mm);

/// The plane through a point; kept is the side to which the normal, of any length but 0, points.
/// Throws std::invalid_argument for a normal without a length, or numbers that are not finite, by
/// name.
glm::dvec4 plane_through(const glm::dvec3& point_mm, const glm::dvec3& normal);

using BoxPlanes = std::array<glm::dvec4, 6>;

/// Where a volume's voxels lie; of the same meaning as in Volume.
struct VoxelPlaces {
    glm::dmat4 voxel_to_patient{1.0};
    std::span<const double> slice_places{};
};

/// The six planes, in the patient, of a box from voxel `first` to voxel `last`; z counts slices.
/// Throws std::invalid_argument, naming axis and values, unless first < last on each axis.
BoxPlanes box_planes_voxels(const glm::dvec3& first, const glm::dvec3& last,
                            const VoxelPlaces& places);

/// A plane of the patient as one of the grid, with a normal of unit length there.
glm::dvec4 grid_plane(const glm::dvec4& plane_mm, const glm::dmat4& voxel_to_patient);

/// The inverse: a plane of the grid as one of the patient, with a normal of unit length there.
glm::dvec4 patient_plane(const glm::dvec4& plane_grid, const glm::dmat4& voxel_to_patient);

}  // namespace pxpl5::host
