#include "host/scene/camera.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <limits>

namespace pxpl5::host {

namespace {

constexpr double half_angle_rad = 15.0 / 180.0 * glm::pi<double>();
/// The sphere around a volume's box is larger than what is in it: fill the picture a little more.
constexpr double fill = 1.3;
constexpr double depth_margin = 1.02;

/// A point's place across the picture, over its distance from the eye.
struct Sight {
    double across_mm, distance_mm;
};

/// The tangents of the outermost points after a shift.
struct Extent {
    double least = std::numeric_limits<double>::max(), most = -least;
};

Extent extent_of(std::span<const Sight> sights, double shift_mm) {
    Extent extent;
    for (const Sight& sight : sights) {
        const double tangent = (sight.across_mm + shift_mm) / sight.distance_mm;
        extent.least = std::min(extent.least, tangent);
        extent.most = std::max(extent.most, tangent);
    }
    return extent;
}

/// The shift after which the outermost points are equally far from the middle.
double centering_shift_mm(std::span<const Sight> sights, double most_mm) {
    double low = -most_mm, high = most_mm;
    constexpr int halvings = 60;
    for (int i = 0; i < halvings; ++i) {
        const double middle = (low + high) / 2;
        const Extent extent = extent_of(sights, middle);
        (extent.least + extent.most > 0 ? high : low) = middle;
    }
    return (low + high) / 2;
}

}  // namespace

Camera fitted(Camera camera, const Subject& subject, std::span<const glm::dvec3> points_mm,
              double share) {
    assert(!points_mm.empty());
    camera.zoom = 1;
    camera.pan_mm = {};
    const glm::dmat4 to_eye = camera_matrices(camera, subject, 1).patient_to_eye;
    double widest = 0;
    for (const int axis : {0, 1}) {
        std::vector<Sight> sights;
        for (const glm::dvec3& p_mm : points_mm) {
            const glm::dvec4 p_eye = to_eye * glm::dvec4(p_mm, 1);
            sights.push_back({p_eye[axis], -p_eye.z});
        }
        // A hundredth of a millimeter is less than a pixel of the largest picture.
        const double shift_mm = centering_shift_mm(sights, 2 * subject.radius_mm);
        camera.pan_mm[axis] = std::round(shift_mm * 100) / 100;
        widest = std::max(widest, extent_of(sights, shift_mm).most);
    }
    const double zoom = share * std::tan(half_angle_rad) / (fill * widest);
    camera.zoom = std::floor(zoom * 1000) / 1000;  // Short words, for scripts and the page.
    return camera;
}

const std::vector<NamedView>& named_views() {
    static const std::vector<NamedView> views = {
        {"anterior", {0, 0}}, {"posterior", {180, 0}}, {"left", {90, 0}},
        {"right", {270, 0}},  {"superior", {180, 90}}, {"inferior", {0, -90}},
    };
    return views;
}

std::optional<ViewAngles> find_view(std::string_view name) {
    for (const NamedView& view : named_views()) {
        if (view.name == name) {
            return view.angles;
        }
    }
    return std::nullopt;
}

Subject subject_of(int nx, int ny, int nz, const glm::dmat4& voxel_to_patient) {
    return subject_of(glm::dvec3(nx, ny, nz) - 1.0, voxel_to_patient);
}

Subject subject_of(const glm::dvec3& last, const glm::dmat4& voxel_to_patient) {
    const auto place = [&](glm::dvec3 p_voxel) {
        return glm::dvec3(voxel_to_patient * glm::dvec4(p_voxel, 1.0));
    };
    Subject subject{place(last * 0.5), 0};
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p(corner & 1 ? last.x : 0, corner & 2 ? last.y : 0,
                           corner & 4 ? last.z : 0);
        subject.radius_mm = std::max(subject.radius_mm, glm::distance(place(p), subject.center_mm));
    }
    return subject;
}

double camera_distance_mm(const Subject& subject) {
    return subject.radius_mm / std::sin(half_angle_rad);
}

CameraMatrices camera_matrices(const Camera& camera, const Subject& subject, double aspect) {
    assert(aspect > 0);
    assert(camera.zoom > 0);
    assert(subject.radius_mm > 0);
    const double azimuth = camera.angles.azimuth_deg / 180.0 * glm::pi<double>();
    const double elevation = camera.angles.elevation_deg / 180.0 * glm::pi<double>();
    // Patient axes: x left, y posterior, z superior. At azimuth 0 the viewer is anterior (-y).
    const glm::dvec3 back(std::sin(azimuth) * std::cos(elevation),
                          -std::cos(azimuth) * std::cos(elevation), std::sin(elevation));
    const glm::dvec3 level(std::cos(azimuth), std::sin(azimuth), 0);
    const glm::dvec3 upright = glm::cross(back, level);
    const double roll = camera.roll_deg / 180.0 * glm::pi<double>();
    const glm::dvec3 right = std::cos(roll) * level - std::sin(roll) * upright;
    const glm::dvec3 up = std::sin(roll) * level + std::cos(roll) * upright;

    const double distance = camera_distance_mm(subject);
    CameraMatrices m{glm::dmat4(1.0), glm::dmat4(0.0)};
    for (int axis = 0; axis < 3; ++axis) {
        m.patient_to_eye[axis] = glm::dvec4(right[axis], up[axis], back[axis], 0);
    }
    m.patient_to_eye[3] = glm::dvec4(camera.pan_mm.x - glm::dot(right, subject.center_mm),
                                     camera.pan_mm.y - glm::dot(up, subject.center_mm),
                                     -glm::dot(back, subject.center_mm) - distance, 1);

    const double near = distance - subject.radius_mm * depth_margin;
    const double far = distance + subject.radius_mm * depth_margin;
    const double scale = camera.zoom * fill / std::tan(half_angle_rad);
    // The subject fills the shorter side of the picture.
    m.projection[0][0] = aspect > 1 ? scale / aspect : scale;
    m.projection[1][1] = aspect > 1 ? scale : scale * aspect;
    m.projection[2][2] = -(far + near) / (far - near);
    m.projection[2][3] = -1;
    m.projection[3][2] = -2 * far * near / (far - near);
    return m;
}

}  // namespace pxpl5::host
