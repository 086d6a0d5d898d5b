#include "host/surface/export/mesh_smooth.hpp"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>

#include "host/surface/edge_table.hpp"

namespace pxpl5::host {

namespace {

constexpr double towards = 0.5, back = -0.51;  // Taubin's lambda and mu.

/// The vertices that share an edge with each vertex, one list after the other.
struct Neighbors {
    std::vector<std::size_t> starts;
    std::vector<std::uint32_t> vertices;
    std::vector<bool> is_open;  ///< Per vertex: it has an edge with one triangle.
};

Neighbors neighbors_of(const WeldedMesh& mesh, const Pause& pause) {
    const EdgeTable edges(mesh, pause);
    const std::size_t count = mesh.keys.size();
    Neighbors found{std::vector<std::size_t>(count + 1), {}, std::vector<bool>(count)};
    edges.for_each([&](std::uint32_t low, std::span<const EdgeUse> uses) {
        const std::uint32_t high = uses.front().high;
        ++found.starts[low + 1];
        ++found.starts[high + 1];
        if (uses.size() == 1) {
            found.is_open[low] = found.is_open[high] = true;
        }
    });
    std::partial_sum(found.starts.begin(), found.starts.end(), found.starts.begin());
    found.vertices.resize(found.starts.back());
    std::vector<std::size_t> next(found.starts.begin(), found.starts.end() - 1);
    edges.for_each([&](std::uint32_t low, std::span<const EdgeUse> uses) {
        const std::uint32_t high = uses.front().high;
        found.vertices[next[low]++] = high;
        found.vertices[next[high]++] = low;
    });
    return found;
}

/// Moves all vertices by a share of the way to the mean of their neighbors. A mean in the grid is
/// the mean in millimeters, because VolumeGrid::p_mm() is affine.
void step(const Neighbors& near, double share, std::vector<glm::dvec3>& p, const Pause& pause) {
    const std::vector<glm::dvec3> before = p;
    for (std::size_t v = 0; v < p.size(); ++v) {
        pause_at(v, pause);
        const std::size_t first = near.starts[v], end = near.starts[v + 1];
        if (near.is_open[v] || first == end) {
            continue;
        }
        glm::dvec3 sum(0);
        for (std::size_t i = first; i < end; ++i) {
            sum += before[near.vertices[i]];
        }
        p[v] += share * (sum / static_cast<double>(end - first) - before[v]);
    }
}

std::vector<glm::dvec3> places_mm(const WeldedMesh& mesh, const VolumeGrid& grid) {
    std::vector<glm::dvec3> places;
    places.reserve(mesh.p_grid.size());
    for (const glm::vec3& p : mesh.p_grid) {
        places.push_back(grid.p_mm(glm::dvec3(p)));
    }
    return places;
}

/// The volume below the triangles, as seen from one place: differences do not depend on the place
/// if the ends of the surface are the same.
double volume_from(const WeldedMesh& mesh, const std::vector<glm::dvec3>& p_mm,
                   const glm::dvec3& place) {
    double volume = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        volume += glm::dot(p_mm[a] - place, glm::cross(p_mm[b] - place, p_mm[c] - place)) / 6;
    }
    return volume;
}

void renew_normals(WeldedMesh& mesh, const std::vector<glm::dvec3>& p_mm) {
    std::vector<glm::dvec3> sums(p_mm.size(), glm::dvec3(0));
    for (const auto& [a, b, c] : mesh.triangles) {
        const glm::dvec3 doubled = glm::cross(p_mm[b] - p_mm[a], p_mm[c] - p_mm[a]);
        for (const std::uint32_t v : {a, b, c}) {
            sums[v] += doubled;
        }
    }
    for (std::size_t v = 0; v < sums.size(); ++v) {
        if (const double length = glm::length(sums[v]); length > 0) {
            mesh.normals[v] = glm::vec3(sums[v] / length);
        }
    }
}

}  // namespace

Smoothing smooth_mesh(WeldedMesh& mesh, const VolumeGrid& grid, int passes, const Pause& pause) {
    if (mesh.triangles.empty()) {
        return {};
    }
    const std::vector<glm::dvec3> before_mm = places_mm(mesh, grid);
    const Neighbors near = neighbors_of(mesh, pause);
    std::vector<glm::dvec3> p(mesh.p_grid.begin(), mesh.p_grid.end());
    for (int pass = 0; pass < passes; ++pass) {
        step(near, towards, p, pause);
        step(near, back, p, pause);
    }
    glm::dvec3 low(mesh.p_grid.front()), high = low;
    for (const glm::vec3& place : mesh.p_grid) {
        low = glm::min(low, glm::dvec3(place));
        high = glm::max(high, glm::dvec3(place));
    }
    for (std::size_t v = 0; v < p.size(); ++v) {
        if (!near.is_open[v]) {
            mesh.p_grid[v] = glm::vec3(glm::clamp(p[v], low, high));
        }
    }
    const std::vector<glm::dvec3> after_mm = places_mm(mesh, grid);
    Smoothing smoothing;
    for (std::size_t v = 0; v < p.size(); ++v) {
        const double moved_mm = glm::distance(before_mm[v], after_mm[v]);
        smoothing.farthest_mm = std::max(smoothing.farthest_mm, moved_mm);
        smoothing.mean_mm += moved_mm / static_cast<double>(p.size());
    }
    smoothing.volume_mm3 = volume_from(mesh, after_mm, before_mm.front()) -
                           volume_from(mesh, before_mm, before_mm.front());
    renew_normals(mesh, after_mm);
    return smoothing;
}

}  // namespace pxpl5::host
