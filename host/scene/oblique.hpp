// Slices along any plane of the patient: values between voxels, and where surfaces cut them.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "host/scene/slice.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// A picture's place in the patient, LPS.
struct ObliquePlane {
    glm::dvec3 center_mm{0};                   ///< Middle of the picture.
    glm::dvec3 right{1, 0, 0}, down{0, 1, 0};  ///< Unit length, at a right angle.
    int width = 1, height = 1;                 ///< Pixels.
    double pixel_mm = 1;                       ///< Distance between the middles of neighbors.
};

/// Turns from the axial plane. The tilt is about the axis from right to left: 90 is coronal. The
/// turn is then about the axis from top to bottom of the picture: 90 after a tilt of 90 is
/// sagittal.
struct ObliqueAngles {
    double tilt_deg = 0, turn_deg = 0;
};

/// Pixels along each side of oblique_plane(), at most.
inline constexpr int max_oblique_px = 512;

/// Returns the middle of the voxels' outermost middles, LPS.
glm::dvec3 middle_mm(const Volume& volume);

/// Returns the plane through a place that shows the whole volume. Its picture is a square around
/// the middle of the volume, as long as the diagonal of the volume.
///
/// least_pixel_mm  Size of the pixels, unless they would be more than max_oblique_px.
ObliquePlane oblique_plane(const Volume& volume, const ObliqueAngles& angles,
                           const glm::dvec3& through_mm, double least_pixel_mm);

/// Returns whether the plane meets the volume between the middles of its outermost voxels.
bool meets(const ObliquePlane& plane, const Volume& volume);

/// Returns the middle of pixel (x, y), counted from 0 at the top left.
glm::dvec3 place_mm(const ObliquePlane& plane, double x, double y);

/// Returns the values at the middles of the pixels, row by row from the top left: trilinear between
/// the voxels, where the voxels lie in the patient. Not a number beyond the middles of the
/// outermost voxels.
std::vector<float> oblique_values(const Volume& volume, const ObliquePlane& plane);

/// The frame of an oblique slice: sides and letters. It has no axes of voxels.
SliceFrame oblique_frame(const ObliquePlane& plane);

/// Contours of the isovalue, by marching squares on the values of the pixels. They are approximate:
/// the surface has its vertices on the edges of the cells of voxels. No contour runs along the
/// border of the volume.
std::vector<ContourPiece> oblique_contour(const ObliquePlane& plane,
                                          const std::vector<float>& values, double isovalue);

}  // namespace pxpl5::host
