// Closed solids whose triangles, volume and normals are known, to be written and read again.
#pragma once

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "host/io/mesh/mesh_export.hpp"

namespace pxpl5::test {

/// A mesh that owns what MeshSurface looks at.
struct Solid {
    std::string name;
    std::array<std::uint8_t, 3> color{};
    std::vector<host::io::MeshPoint> vertices;
    std::vector<std::uint32_t> indices;

    host::io::MeshSurface view() const { return {name, color, vertices, indices}; }
};

/// Four corners at unlike places along each axis, so that every swap and every sign shows. Its
/// volume is 2 * 3 * 4 / 6 = 4 mm3; triangles are counter-clockwise from outside.
inline Solid tetrahedron() {
    const glm::vec3 a(10, 20, -30);
    const std::array corners = {a, a + glm::vec3(2, 0, 0), a + glm::vec3(0, 3, 0),
                                a + glm::vec3(0, 0, 4)};
    const glm::vec3 middle = (corners[0] + corners[1] + corners[2] + corners[3]) / 4.0F;
    Solid solid{"bone", {236, 226, 200}, {}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}};
    for (const glm::vec3& p : corners) {
        solid.vertices.push_back({p, glm::normalize(p - middle)});
    }
    return solid;
}

/// A sphere of 2 * around * (rings - 1) triangles: `rings` from pole to pole.
inline Solid sphere(glm::vec3 center, float radius, std::uint32_t rings, std::uint32_t around) {
    constexpr double pi = 3.14159265358979323846;
    Solid solid{"skin of a ball", {30, 144, 255}, {}, {}};
    const auto add = [&](double polar, double azimuth) {
        const glm::vec3 n(static_cast<float>(std::sin(polar) * std::cos(azimuth)),
                          static_cast<float>(std::sin(polar) * std::sin(azimuth)),
                          static_cast<float>(std::cos(polar)));
        solid.vertices.push_back({center + radius * n, n});
    };
    add(0, 0);
    for (std::uint32_t ring = 1; ring < rings; ++ring) {
        for (std::uint32_t step = 0; step < around; ++step) {
            add(pi * ring / rings, 2 * pi * step / around);
        }
    }
    add(pi, 0);
    const auto at = [&](std::uint32_t ring, std::uint32_t step) {
        const std::uint32_t last = static_cast<std::uint32_t>(solid.vertices.size()) - 1;
        return ring == 0 ? 0 : ring == rings ? last : 1 + (ring - 1) * around + step % around;
    };
    for (std::uint32_t ring = 0; ring < rings; ++ring) {
        for (std::uint32_t step = 0; step < around; ++step) {
            const std::uint32_t a = at(ring, step), b = at(ring + 1, step),
                                c = at(ring + 1, step + 1), d = at(ring, step + 1);
            if (ring + 1 < rings) {
                solid.indices.insert(solid.indices.end(), {a, b, c});
            }
            if (ring > 0) {
                solid.indices.insert(solid.indices.end(), {a, c, d});
            }
        }
    }
    return solid;
}

/// Volume inside, positive if triangles are counter-clockwise from outside.
template <typename Points, typename Indices>
double signed_volume(const Points& points, const Indices& indices) {
    double sum = 0;
    for (std::size_t first = 0; first < indices.size(); first += 3) {
        const glm::dvec3 a(points[indices[first]]), b(points[indices[first + 1]]),
            c(points[indices[first + 2]]);
        sum += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return sum;
}

}  // namespace pxpl5::test
