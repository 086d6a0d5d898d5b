// Where the viewer stands: named views and angles, turned into the matrices of a frame.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace pxpl5::host {

/// Direction of the viewer as seen from the volume's center, in patient axes.
struct ViewAngles {
    double azimuth_deg = 0;    ///< 0 anterior, 90 patient's left, 180 posterior.
    double elevation_deg = 0;  ///< 90 superior, -90 inferior.

    friend bool operator==(const ViewAngles&, const ViewAngles&) = default;
};

struct NamedView {
    std::string_view name;
    ViewAngles angles;
};

/// anterior, posterior, left, right, superior, inferior. Seen from inferior, the patient's left is
/// on the picture's right and anterior is up, as radiologists show axial slices.
const std::vector<NamedView>& named_views();

/// The view of that name; nothing if there is none.
std::optional<ViewAngles> find_view(std::string_view name);

/// The sphere around the volume, which the picture must contain.
struct Subject {
    glm::dvec3 center_mm{0};
    double radius_mm = 1;
};

/// The sphere around the box from the grid's origin to its `last` position, placed by
/// `voxel_to_patient`.
Subject subject_of(const glm::dvec3& last, const glm::dmat4& voxel_to_patient);
/// The same for nx x ny x nz voxel centers that are evenly spaced.
Subject subject_of(int nx, int ny, int nz, const glm::dmat4& voxel_to_patient);

/// The radius at which an archive is shown, whatever its units: depth and clipping are made for
/// the sizes of patients.
inline constexpr double scene_radius_mm = 100;

struct Camera {
    ViewAngles angles;
    double zoom =
        1;  ///< 1 shows the subject's sphere with little margin; each doubling halves the field.
    double roll_deg = 0;   ///< Turns the picture counter-clockwise.
    glm::dvec2 pan_mm{0};  ///< Moves the subject's center to the picture's right, and up.

    friend bool operator==(const Camera&, const Camera&) = default;
};

/// The camera with the zoom and pan that show all points within `share` of a square picture, in its
/// middle. A picture with other sides shows them, too.
///
/// points_mm  In the patient, LPS; one at least.
Camera fitted(Camera camera, const Subject& subject, std::span<const glm::dvec3> points_mm,
              double share);

struct CameraMatrices {
    glm::dmat4 patient_to_eye;  ///< Millimeters: x right, y up, looking along -z.
    glm::dmat4 projection;      ///< Eye to clip space, OpenGL convention.
};

/// From the camera to the subject's center, in millimeters.
double camera_distance_mm(const Subject& subject);

/// Perspective of 30 degrees at zoom 1; the near and far planes enclose the subject at any zoom.
///
/// aspect   Width over height of the picture, > 0.
CameraMatrices camera_matrices(const Camera& camera, const Subject& subject, double aspect);

}  // namespace pxpl5::host
