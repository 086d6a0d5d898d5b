// Checks that the first view of a volume shows its first surfaces whole and large.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "host/commands/fit_view.hpp"
#include "host/commands/text/first_surfaces.hpp"
#include "host/commands/text/tissues.hpp"
#include "host/phantom/phantom.hpp"
#include "host/volume/typed_values.hpp"

namespace pxpl5::test {

inline double isovalue_of(const host::FirstSurface& surface, const host::Volume& volume) {
    for (const host::PhantomSurface& each : host::suggested_surfaces(volume.name)) {
        if (each.name == surface.name) {
            return each.isovalue;
        }
    }
    return surface.isovalue ? *surface.isovalue : host::find_tissue(surface.name)->isovalue_hu;
}

/// Where the isovalue cuts the edges between neighboring voxels, in patient mm: all vertices of
/// the surface lie on such edges.
inline std::vector<glm::dvec3> vertices_of(const host::Volume& volume, double isovalue) {
    std::vector<glm::dvec3> points;
    const glm::ivec3 size(volume.nx, volume.ny, volume.nz);
    const glm::ivec3 steps(1, volume.nx, volume.nx * volume.ny);
    const auto place = [&](glm::dvec3 p_voxel) {
        if (!volume.slice_places.empty()) {
            const auto below = static_cast<std::size_t>(p_voxel.z);
            const std::size_t above = std::min(below + 1, volume.slice_places.size() - 1);
            p_voxel.z = glm::mix(volume.slice_places[below], volume.slice_places[above],
                                 p_voxel.z - static_cast<double>(below));
        }
        return glm::dvec3(volume.voxel_to_patient * glm::dvec4(p_voxel, 1));
    };
    host::with_values(volume, [&](auto values) {
        const auto value = [&](int at) {
            return static_cast<double>(values[static_cast<std::size_t>(at)]);
        };
        for (int at = 0; at < size.x * size.y * size.z; ++at) {
            const glm::ivec3 p(at % size.x, at / size.x % size.y, at / steps.z);
            for (int axis = 0; axis < 3; ++axis) {
                if (p[axis] + 1 == size[axis]) {
                    continue;
                }
                const double a = value(at), b = value(at + steps[axis]);
                if ((a >= isovalue) != (b >= isovalue)) {
                    glm::dvec3 crossing(p);
                    crossing[axis] += (isovalue - a) / (b - a);
                    points.push_back(place(crossing));
                }
            }
        }
    });
    return points;
}

/// The first view, in pictures of three forms and from these directions.
inline void check_first_view(const host::Volume& volume, const std::vector<std::string>& views) {
    std::vector<host::Surface> surfaces;
    std::vector<glm::dvec3> points;
    for (const host::FirstSurface& first : host::first_surfaces(volume)) {
        surfaces.emplace_back().isovalue = isovalue_of(first, volume);
        const std::vector<glm::dvec3> more = vertices_of(volume, surfaces.back().isovalue);
        points.insert(points.end(), more.begin(), more.end());
    }
    CAPTURE(volume.name);
    REQUIRE_FALSE(points.empty());
    const host::Subject subject = host::subject_of(
        glm::dvec3(volume.nx - 1, volume.ny - 1, last_place(volume)), volume.voxel_to_patient);
    for (const std::string& view : views) {
        const host::Camera camera =
            host::fitted_to_surfaces(volume, surfaces, {host::find_view(view).value(), 1});
        for (const double aspect : {1.0, 1.9, 0.5}) {
            const host::CameraMatrices m = host::camera_matrices(camera, subject, aspect);
            const glm::dmat4 to_clip = m.projection * m.patient_to_eye;
            glm::dvec2 low(1e9), high(-1e9);
            for (const glm::dvec3& point : points) {
                const glm::dvec4 clip = to_clip * glm::dvec4(point, 1);
                low = glm::min(low, glm::dvec2(clip) / clip.w);
                high = glm::max(high, glm::dvec2(clip) / clip.w);
            }
            CAPTURE(view);
            CAPTURE(aspect);
            // Half of a side is 1. The shorter side of the picture counts.
            CHECK(std::min(low.x, low.y) > -0.95);
            CHECK(std::max(high.x, high.y) < 0.95);
            const glm::dvec2 extent = (high - low) * glm::max(glm::dvec2(aspect, 1 / aspect), 1.0);
            CHECK(std::max(extent.x, extent.y) > 1.0);
        }
    }
}

}  // namespace pxpl5::test
