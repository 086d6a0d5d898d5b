#include "host/surface/components.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>

#include "host/base/error.hpp"
#include "host/surface/disjoint_sets.hpp"
#include "host/surface/edge_table.hpp"
#include "host/surface/mesh_measure.hpp"

namespace pxpl5::host {

namespace {

constexpr double mm3_per_ml = 1000;

/// Sums over a component.
struct ComponentSums {
    VolumeSums volume;
    glm::dvec3 moment{0};  ///< Moment of six times the area, in mm3.
    std::size_t border_edges = 0, open_edges = 0;
};

/// Numbers the components by their sizes. Returns that of each triangle's.
std::vector<std::uint32_t> number_components(DisjointSets& pieces, std::size_t triangles,
                                             std::vector<MeshComponent>& components) {
    std::vector<std::uint32_t> found(triangles), sizes;
    for (std::uint32_t t = 0; t < triangles; ++t) {
        // The root is the lowest triangle, so it has been numbered.
        const std::uint32_t root = pieces.root(t);
        if (root == t) {
            found[t] = static_cast<std::uint32_t>(components.size());
            components.emplace_back().first_triangle = t;
        } else {
            found[t] = found[root];
        }
        ++components[found[t]].triangles;
    }
    std::vector<std::uint32_t> order(components.size()), number(components.size());
    std::iota(order.begin(), order.end(), std::uint32_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return components[a].triangles > components[b].triangles;
    });
    std::vector<MeshComponent> sorted(components.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        sorted[i] = components[order[i]];
        number[order[i]] = i;
    }
    components = std::move(sorted);
    for (std::uint32_t& f : found) f = number[f];
    return found;
}

void finish(const ComponentSums& sums, const MeshMeasure& measure, MeshComponent& component) {
    component.closed = sums.border_edges + sums.open_edges == 0;
    if (component.closed) {
        component.volume_mm3 = measure.plain_mm3(sums.volume);
    } else if (sums.open_edges == 0) {
        const double inner_mm3 = measure.within_box_mm3(sums.volume);
        component.volume_mm3 =
            inner_mm3 > measure.box_mm3() / 2 ? inner_mm3 - measure.box_mm3() : inner_mm3;
    }
    // A component without area has the middle of its box.
    component.center_mm = component.area_mm2 > 0
                              ? sums.moment / (6 * component.area_mm2)
                              : (component.bounds_mm.low + component.bounds_mm.high) / 2.0;
}

bool is_at_least(const MeshComponent& c, ComponentMeasure measure, double least) {
    switch (measure) {
        case ComponentMeasure::triangles:
            return static_cast<double>(c.triangles) >= least;
        case ComponentMeasure::area_mm2:
            return c.area_mm2 >= least;
        case ComponentMeasure::volume_ml:
            return std::abs(c.volume_mm3.value_or(0)) / mm3_per_ml >= least;
    }
    return false;
}

template <class Wanted>
Shown show_if(const MeshComponents& parts, Wanted wanted) {
    std::vector<std::uint8_t> of_component(parts.components.size());
    for (std::size_t i = 0; i < of_component.size(); ++i)
        of_component[i] = wanted(parts.components[i]) ? 1 : 0;
    Shown shown(parts.of_triangle.size());
    std::transform(parts.of_triangle.begin(), parts.of_triangle.end(), shown.begin(),
                   [&](std::uint32_t component) { return of_component[component]; });
    return shown;
}

}  // namespace

glm::dvec3 nearest_of_triangle(glm::dvec3 p, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const glm::dvec3 ab = b - a, ac = c - a, ap = p - a;
    const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const glm::dvec3 bp = p - b;
    const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
    const glm::dvec3 cp = p - c;
    const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return b + (d4 - d3) / (d4 - d3 + (d5 - d6)) * (c - b);
    const double sum = va + vb + vc;
    return a + vb / sum * ab + vc / sum * ac;
}

MeshComponents find_components(const WeldedMesh& mesh, const VolumeGrid& grid) {
    const MeshMeasure measure(mesh, grid);
    const EdgeTable edges(mesh);
    DisjointSets pieces(mesh.triangles.size());
    edges.for_each([&](std::uint32_t, std::span<const EdgeUse> uses) {
        for (const EdgeUse& use : uses.subspan(1)) {
            pieces.join(uses[0].triangle(), use.triangle());
        }
    });
    MeshComponents out;
    out.of_triangle = number_components(pieces, mesh.triangles.size(), out.components);
    std::vector<ComponentSums> sums(out.components.size());
    edges.for_each([&](std::uint32_t low, std::span<const EdgeUse> uses) {
        if (uses.size() != 1) return;
        const EdgeUse& use = uses[0];
        ComponentSums& s = sums[out.of_triangle[use.triangle()]];
        const auto& middles = measure.middles();
        if (common_border(middles[low], middles[use.high], grid) == 0) {
            ++s.open_edges;
            return;
        }
        ++s.border_edges;
        measure.add_border(use.forward() ? low : use.high, use.forward() ? use.high : low,
                           s.volume);
    });
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t number = out.of_triangle[t];
        MeshComponent& component = out.components[number];
        const glm::dvec3 normal = measure.doubled_normal_grid(t);
        const double area_mm2 = glm::length(measure.to_mm2(normal)) / 2;
        component.area_mm2 += area_mm2;
        measure.add_triangle(t, normal, sums[number].volume);
        for (const std::uint32_t vertex : mesh.triangles[t]) {
            const glm::dvec3 p_mm = measure.p_mm(vertex);
            component.bounds_mm.add(p_mm);
            sums[number].moment += 2 * area_mm2 * p_mm;
        }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) finish(sums[i], measure, out.components[i]);
    return out;
}

Shown show_component(const MeshComponents& parts, std::size_t component) {
    if (component >= parts.components.size()) {
        throw RequestError(ExitCode::failed, fmt::format("component {}: the surface has {}",
                                                         component + 1, parts.components.size()));
    }
    const MeshComponent* const wanted = &parts.components[component];
    return show_if(parts, [wanted](const MeshComponent& c) { return &c == wanted; });
}

Shown show_at_least(const MeshComponents& parts, ComponentMeasure measure, double least) {
    return show_if(parts, [=](const MeshComponent& c) { return is_at_least(c, measure, least); });
}

std::optional<SurfacePoint> nearest_point(const WeldedMesh& mesh, const VolumeGrid& grid,
                                          glm::dvec3 p_mm) {
    std::vector<glm::dvec3> points;
    points.reserve(mesh.p_grid.size());
    for (const glm::vec3& p : mesh.p_grid) points.push_back(grid.p_mm(p));
    std::optional<SurfacePoint> best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const glm::dvec3 q = nearest_of_triangle(p_mm, points[a], points[b], points[c]);
        const double square = glm::dot(q - p_mm, q - p_mm);
        if (!(square < least)) continue;
        least = square;
        best = SurfacePoint{t, q, std::sqrt(square)};
    }
    return best;
}

WeldedMesh shown_part(const WeldedMesh& mesh, const Shown& shown) {
    assert(shown.size() == mesh.triangles.size());
    std::vector<std::uint32_t> vertex_of(mesh.keys.size());
    for (std::size_t t = 0; t < shown.size(); ++t) {
        if (shown[t] == 0) continue;
        for (const std::uint32_t vertex : mesh.triangles[t]) vertex_of[vertex] = 1;
    }
    WeldedMesh part;
    for (std::size_t v = 0; v < vertex_of.size(); ++v) {
        if (vertex_of[v] == 0) continue;
        vertex_of[v] = static_cast<std::uint32_t>(part.keys.size());
        part.keys.push_back(mesh.keys[v]);
        part.p_grid.push_back(mesh.p_grid[v]);
        part.normals.push_back(mesh.normals[v]);
    }
    for (const SlabTriangles& slab : mesh.slabs) {
        const std::size_t first = part.triangles.size();
        for (std::size_t t = slab.first; t < slab.first + slab.count; ++t) {
            if (shown[t] == 0) continue;
            const auto& [a, b, c] = mesh.triangles[t];
            part.triangles.push_back({vertex_of[a], vertex_of[b], vertex_of[c]});
            if (!mesh.cells.empty()) part.cells.push_back(mesh.cells[t]);
        }
        part.slabs.push_back({slab.slab, first, part.triangles.size() - first});
    }
    return part;
}

}  // namespace pxpl5::host
