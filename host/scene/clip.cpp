#include "host/scene/clip.hpp"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <stdexcept>

#include "host/scene/slice_places.hpp"

namespace pxpl5::host {

namespace {

void check_finite(const glm::dvec3& v, const char* name) {
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
        throw std::invalid_argument(
            fmt::format("clip plane: its {} ({}, {}, {}) is not finite", name, v.x, v.y, v.z));
    }
}

void check_box(const glm::dvec3& low, const glm::dvec3& high) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(low[axis] < high[axis])) {
            throw std::invalid_argument(
                fmt::format("clip box: {} runs from {} to {} voxels; the first "
                            "must be less",
                            "xyz"[axis], low[axis], high[axis]));
        }
    }
}

BoxPlanes box_between(const glm::dvec3& low, const glm::dvec3& high) {
    BoxPlanes planes{};
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec4 plane(0);
        plane[axis] = 1;
        plane.w = -low[axis];
        planes[static_cast<std::size_t>(2 * axis)] = plane;
        plane[axis] = -1;
        plane.w = high[axis];
        planes[static_cast<std::size_t>(2 * axis + 1)] = plane;
    }
    return planes;
}

glm::dvec4 with_unit_normal(const glm::dvec4& plane) {
    return plane / glm::length(glm::dvec3(plane));
}

}  // namespace

std::optional<glm::dvec4> axis_plane(char towards, double at_mm) {
    switch (towards) {
        case 'L':
            return glm::dvec4(1, 0, 0, -at_mm);
        case 'R':
            return glm::dvec4(-1, 0, 0, -at_mm);
        case 'P':
            return glm::dvec4(0, 1, 0, -at_mm);
        case 'A':
            return glm::dvec4(0, -1, 0, -at_mm);
        case 'S':
            return glm::dvec4(0, 0, 1, -at_mm);
        case 'I':
            return glm::dvec4(0, 0, -1, -at_mm);
        default:
            return std::nullopt;
    }
}

glm::dvec4 plane_through(const glm::dvec3& point_mm, const glm::dvec3& normal) {
    check_finite(point_mm, "point");
    check_finite(normal, "normal");
    const double length = glm::length(normal);
    if (!(length > 0)) {
        throw std::invalid_argument("clip plane: its normal (0, 0, 0) has no length");
    }
    const glm::dvec3 n = normal / length;
    return {n, -glm::dot(n, point_mm)};
}

BoxPlanes box_planes_voxels(const glm::dvec3& first, const glm::dvec3& last,
                            const VoxelPlaces& places) {
    check_box(first, last);
    BoxPlanes planes = box_between({first.x, first.y, place_of_slice(first.z, places.slice_places)},
                                   {last.x, last.y, place_of_slice(last.z, places.slice_places)});
    for (glm::dvec4& plane : planes) {
        plane = patient_plane(plane, places.voxel_to_patient);
    }
    return planes;
}

glm::dvec4 grid_plane(const glm::dvec4& plane_mm, const glm::dmat4& voxel_to_patient) {
    // n . (M g) + d is a form of g whose coefficients are the transpose's image of the plane.
    return with_unit_normal(glm::transpose(voxel_to_patient) * plane_mm);
}

glm::dvec4 patient_plane(const glm::dvec4& plane_grid, const glm::dmat4& voxel_to_patient) {
    return with_unit_normal(glm::transpose(glm::inverse(voxel_to_patient)) * plane_grid);
}

}  // namespace pxpl5::host
