#include "host/io/mesh/mesh_polygon.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>

#include "host/io/mesh/mesh_export.hpp"
#include "host/surface/export/plane_cut.hpp"

namespace pxpl5::host::io {

namespace {

/// The corners in the plane of the polygon, counter-clockwise.
std::vector<glm::dvec2> in_its_plane(const MeshFile& mesh, std::span<const std::uint32_t> corners) {
    const auto p = [&](std::size_t i) {
        return glm::dvec3(mesh.points[corners[i % corners.size()]]);
    };
    const glm::dvec3 first = p(0);
    glm::dvec3 normal(0);
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        normal += glm::cross(p(i) - first, p(i + 1) - first);
    }
    const glm::dvec3 size = glm::abs(normal);
    const glm::dvec3 least = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                             : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                  : glm::dvec3(0, 0, 1);
    const glm::dvec3 right = glm::cross(least, normal), up = glm::cross(normal, right);
    const double right_length = glm::length(right), up_length = glm::length(up);
    std::vector<glm::dvec2> flat;
    if (!(right_length > 0 && up_length > 0)) return flat;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        flat.emplace_back(glm::dot(right, p(i) - first) / right_length,
                          glm::dot(up, p(i) - first) / up_length);
    }
    return flat;
}

bool is_convex(const std::vector<glm::dvec2>& flat) {
    for (std::size_t i = 0; i < flat.size(); ++i) {
        const glm::dvec2 &a = flat[i], &b = flat[(i + 1) % flat.size()],
                         &c = flat[(i + 2) % flat.size()];
        if ((b.x - a.x) * (c.y - b.y) < (b.y - a.y) * (c.x - b.x)) return false;
    }
    return true;
}

}  // namespace

void add_polygon(MeshFile& out, std::span<const std::uint32_t> corners) {
    if (corners.size() > 3) {
        const std::vector<glm::dvec2> flat = in_its_plane(out, corners);
        if (!is_convex(flat)) {
            std::vector<std::uint32_t> loop(corners.size());
            for (std::uint32_t i = 0; i < loop.size(); ++i) loop[i] = i;
            const LoopTriangles ears = triangulate_loops(flat, {loop});
            if (ears.added.empty()) {
                for (const auto& [a, b, c] : ears.triangles) {
                    out.indices.insert(out.indices.end(), {corners[a], corners[b], corners[c]});
                }
                return;
            }
        }
    }
    for (std::size_t i = 2; i < corners.size(); ++i) {
        out.indices.insert(out.indices.end(), {corners[0], corners[i - 1], corners[i]});
    }
}

double number_of(const std::string& where, std::string_view word) {
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    double number = 0;
    const auto [end, failure] =
        std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (failure != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(number)) {
        throw MeshError(fmt::format("{}: '{}' is not a finite number", where, word));
    }
    return number;
}

}  // namespace pxpl5::host::io
