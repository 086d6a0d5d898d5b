// Clip planes: from what a person says, in patient millimetres or voxels, to a frame's planes.
//
// A frame's planes act on grid positions (see host/volume.hpp): a vertex is kept where
// a x + b y + c z + d >= 0. Grid positions are an affine image of the patient's millimetres, so a
// plane there is a plane here, also where slices are unevenly spaced; slices, counted, are not.
#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>

namespace pxpl5::host {

/// Keeps the side to which the normal points, and the plane itself.
struct ClipPlane {
    glm::dvec3 point_mm{0};      ///< On the plane; patient axes, LPS.
    glm::dvec3 normal{0, 0, 1};  ///< Of any length but 0.
};

/// The plane across one of the patient's axes.
///
/// towards   L, R (left, right), P, A (posterior, anterior), S, I (superior, inferior): the side
///           that is kept.
/// at_mm     Where, counted that way from the patient's origin: R 20 and L -20 are one place.
/// Returns   Nothing for another letter.
std::optional<ClipPlane> axis_plane(char towards, double at_mm);

/// (a, b, c, d) of the plane in the grid, with (a, b, c) of unit length.
///
/// Throws std::invalid_argument for a normal without a length, or numbers that are not finite, by
/// name.
glm::dvec4 grid_plane(const ClipPlane& plane, const glm::dmat4& voxel_to_patient);

/// The six planes of a box in millimetres: what lies in it is kept.
/// Throws std::invalid_argument, naming axis and values, unless low < high on each axis.
std::array<glm::dvec4, 6> grid_box_mm(const glm::dvec3& low_mm, const glm::dvec3& high_mm,
                                      const glm::dmat4& voxel_to_patient);

/// The six planes of a box from voxel `first` to voxel `last`; z counts slices.
/// slice_places   As Volume::slice_places.
/// Throws std::invalid_argument, naming axis and values, unless first < last on each axis.
std::array<glm::dvec4, 6> grid_box_voxels(const glm::dvec3& first, const glm::dvec3& last,
                                          std::span<const double> slice_places);

}  // namespace pxpl5::host
