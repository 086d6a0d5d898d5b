#include "host/scene/oblique.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <span>

#include "host/scene/overlay.hpp"
#include "host/scene/slice_places.hpp"
#include "host/volume/typed_values.hpp"

namespace pxpl5::host {

namespace {

constexpr double rounding = 1e-6;  // Voxels beyond the border, because of rounded positions.
constexpr float no_number = std::numeric_limits<float>::quiet_NaN();

/// The voxels around a place along one axis, with the share of the second.
struct Between {
    std::size_t low = 0, high = 0;
    double share = 0;
};

/// at  A place in voxels. Returns false beyond the first or last voxel.
bool is_between(double at, int count, Between& between) {
    if (!(at >= -rounding && at <= count - 1 + rounding)) {
        return false;
    }
    const double nearest = std::round(at);
    // A place on a voxel has the value of the voxel alone.
    const double held =
        std::clamp(std::abs(at - nearest) < rounding ? nearest : at, 0.0, count - 1.0);
    between.low = static_cast<std::size_t>(held);
    between.share = held - std::floor(held);
    between.high = between.share > 0 ? between.low + 1 : between.low;
    return true;
}

template <class T>
float value_at(std::span<const T> values, const Volume& volume,
               const std::array<Between, 3>& around) {
    const auto nx = static_cast<std::size_t>(volume.nx), ny = static_cast<std::size_t>(volume.ny);
    const auto along_x = [&](std::size_t y, std::size_t z) {
        const T* row = values.data() + (z * ny + y) * nx;
        const auto& [low, high, share] = around[0];
        const auto first = static_cast<double>(row[low]);
        return share > 0 ? first + share * (static_cast<double>(row[high]) - first) : first;
    };
    const auto along_y = [&](std::size_t z) {
        const auto& [low, high, share] = around[1];
        const double first = along_x(low, z);
        return share > 0 ? first + share * (along_x(high, z) - first) : first;
    };
    const auto& [low, high, share] = around[2];
    const double first = along_y(low);
    return static_cast<float>(share > 0 ? first + share * (along_y(high) - first) : first);
}

/// Returns the corners of the whole volume.
std::array<glm::dvec3, 8> corners_mm(const Volume& volume) {
    return corners_mm(volume, glm::ivec3(0), glm::ivec3(volume.nx, volume.ny, volume.nz) - 1);
}

}  // namespace

glm::dvec3 middle_mm(const Volume& volume) {
    const std::array corners = corners_mm(volume);
    return (corners.front() + corners.back()) / 2.0;
}

ObliquePlane oblique_plane(const Volume& volume, const ObliqueAngles& angles,
                           const glm::dvec3& through_mm, double least_pixel_mm) {
    const double tilt = glm::radians(angles.tilt_deg), turn = glm::radians(angles.turn_deg);
    ObliquePlane plane;
    // Anterior is on top. After a tilt, superior comes to the top.
    plane.down = {0, std::cos(tilt), -std::sin(tilt)};
    const glm::dvec3 untilted_right(1, 0, 0);
    plane.right =
        untilted_right * std::cos(turn) + glm::cross(untilted_right, plane.down) * std::sin(turn);
    const glm::dvec3 middle = middle_mm(volume);
    double length_mm = 0;
    for (const glm::dvec3& corner : corners_mm(volume)) {
        length_mm = std::max(length_mm, 2 * glm::distance(corner, middle));
    }
    plane.pixel_mm = std::max(least_pixel_mm, length_mm / (max_oblique_px - 1));
    plane.width = plane.height =
        std::clamp(static_cast<int>(std::ceil(length_mm / plane.pixel_mm)) + 1, 2, max_oblique_px);
    const glm::dvec3 normal = glm::cross(plane.right, plane.down);
    plane.center_mm = middle + normal * glm::dot(normal, through_mm - middle);
    return plane;
}

bool meets(const ObliquePlane& plane, const Volume& volume) {
    const glm::dvec3 normal = glm::cross(plane.right, plane.down);
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (const glm::dvec3& corner : corners_mm(volume)) {
        const double off_mm = glm::dot(normal, corner - plane.center_mm);
        low = std::min(low, off_mm);
        high = std::max(high, off_mm);
    }
    return low <= rounding && high >= -rounding;
}

glm::dvec3 place_mm(const ObliquePlane& plane, double x, double y) {
    return plane.center_mm + plane.right * ((x - (plane.width - 1) / 2.0) * plane.pixel_mm) +
           plane.down * ((y - (plane.height - 1) / 2.0) * plane.pixel_mm);
}

std::vector<float> oblique_values(const Volume& volume, const ObliquePlane& plane) {
    const glm::dmat4 to_grid = glm::inverse(volume.voxel_to_patient);
    std::vector<float> out;
    out.reserve(static_cast<std::size_t>(plane.width) * static_cast<std::size_t>(plane.height));
    with_values(volume, [&]<class T>(std::span<const T> values) {
        for (int y = 0; y < plane.height; ++y) {
            for (int x = 0; x < plane.width; ++x) {
                const glm::dvec4 grid = to_grid * glm::dvec4(place_mm(plane, x, y), 1);
                const double z = slice_of_place(grid.z, volume.slice_places);
                std::array<Between, 3> around;
                const bool is_inside = is_between(grid.x, volume.nx, around[0]) &&
                                       is_between(grid.y, volume.ny, around[1]) &&
                                       is_between(z, volume.nz, around[2]);
                out.push_back(is_inside ? value_at(values, volume, around) : no_number);
            }
        }
    });
    return out;
}

SliceFrame oblique_frame(const ObliquePlane& plane) {
    const auto side = [&](const glm::dvec3& direction, int count) {
        SliceSide made;
        made.count = count;
        made.spacing_mm = plane.pixel_mm;
        made.begin = direction_letters(-direction);
        made.end = direction_letters(direction);
        return made;
    };
    SliceFrame frame;
    frame.across = side(plane.right, plane.width);
    frame.down = side(plane.down, plane.height);
    return frame;
}

std::vector<ContourPiece> oblique_contour(const ObliquePlane& plane,
                                          const std::vector<float>& values, double isovalue) {
    std::vector<ContourPiece> pieces = slice_contour(
        oblique_frame(plane), {values.begin(), values.end()}, isovalue, SaddleRule::apart);
    const auto width = static_cast<std::size_t>(plane.width);
    std::erase_if(pieces, [&](const ContourPiece& piece) {
        const glm::vec2 middle = (piece.from + piece.to) * 0.5F;
        const auto x = std::min(static_cast<std::size_t>(middle.x), width - 2);
        const auto y = std::min(static_cast<std::size_t>(middle.y),
                                static_cast<std::size_t>(plane.height) - 2);
        const float* corner = values.data() + y * width + x;
        return std::isnan(corner[0]) || std::isnan(corner[1]) || std::isnan(corner[width]) ||
               std::isnan(corner[width + 1]);
    });
    return pieces;
}

}  // namespace pxpl5::host
