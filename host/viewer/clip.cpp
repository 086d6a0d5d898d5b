#include "host/viewer/clip.hpp"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <stdexcept>

#include "host/viewer/slice_places.hpp"

namespace pxpl5::host {

namespace {

void check_finite(const glm::dvec3& v, const char* name) {
    if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
        throw std::invalid_argument(
            fmt::format("clip plane: its {} ({}, {}, {}) is not finite", name, v.x, v.y, v.z));
    }
}

void check_box(const glm::dvec3& low, const glm::dvec3& high, const char* unit) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(low[axis] < high[axis])) {
            throw std::invalid_argument(
                fmt::format("clip box: {} runs from {} to {} {}; the first "
                            "must be less",
                            "xyz"[axis], low[axis], high[axis], unit));
        }
    }
}

}  // namespace

std::optional<ClipPlane> axis_plane(char towards, double at_mm) {
    ClipPlane plane;
    switch (towards) {
        case 'L':
            plane.normal = {1, 0, 0};
            break;
        case 'R':
            plane.normal = {-1, 0, 0};
            break;
        case 'P':
            plane.normal = {0, 1, 0};
            break;
        case 'A':
            plane.normal = {0, -1, 0};
            break;
        case 'S':
            plane.normal = {0, 0, 1};
            break;
        case 'I':
            plane.normal = {0, 0, -1};
            break;
        default:
            return std::nullopt;
    }
    plane.point_mm = plane.normal * at_mm;
    return plane;
}

glm::dvec4 grid_plane(const ClipPlane& plane, const glm::dmat4& voxel_to_patient) {
    check_finite(plane.point_mm, "point");
    check_finite(plane.normal, "normal");
    const double length = glm::length(plane.normal);
    if (!(length > 0)) {
        throw std::invalid_argument("clip plane: its normal (0, 0, 0) has no length");
    }
    const glm::dvec3 n = plane.normal / length;
    // n . (M g) - n . p is a form of g whose coefficients are the transpose's image of the plane.
    const glm::dvec4 grid =
        glm::transpose(voxel_to_patient) * glm::dvec4(n, -glm::dot(n, plane.point_mm));
    return grid / glm::length(glm::dvec3(grid));
}

std::array<glm::dvec4, 6> grid_box_mm(const glm::dvec3& low_mm, const glm::dvec3& high_mm,
                                      const glm::dmat4& voxel_to_patient) {
    check_box(low_mm, high_mm, "mm");
    std::array<glm::dvec4, 6> planes{};
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 normal(0);
        normal[axis] = 1;
        const auto at = static_cast<std::size_t>(2 * axis);
        planes[at] = grid_plane({low_mm, normal}, voxel_to_patient);
        planes[at + 1] = grid_plane({high_mm, -normal}, voxel_to_patient);
    }
    return planes;
}

std::array<glm::dvec4, 6> grid_box_voxels(const glm::dvec3& first, const glm::dvec3& last,
                                          std::span<const double> slice_places) {
    check_box(first, last, "voxels");
    const glm::dvec3 low(first.x, first.y, place_of_slice(first.z, slice_places));
    const glm::dvec3 high(last.x, last.y, place_of_slice(last.z, slice_places));
    return grid_box_mm(low, high, glm::dmat4(1.0));
}

}  // namespace pxpl5::host
