#include "host/surface/components.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <utility>

#include "host/base/error.hpp"
#include "host/surface/disjoint_sets.hpp"
#include "host/surface/edge_table.hpp"
#include "host/surface/mesh_measure.hpp"

namespace pxpl5::host {

namespace {

constexpr double mm3_per_ml = 1000;
constexpr std::size_t components_per_pause = 128;  ///< For each, lines of voxels are searched.

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
    component.closed_but_for_border = sums.open_edges == 0;
    component.cavity = component.closed && measure.is_cavity(sums.volume);
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

/// Shows the components that wanted(number, component) chooses.
template <class Wanted>
Shown show_if(const MeshComponents& parts, Wanted wanted) {
    std::vector<std::uint8_t> of_component(parts.components.size());
    for (std::size_t i = 0; i < of_component.size(); ++i)
        of_component[i] = wanted(i, parts.components[i]) ? 1 : 0;
    Shown shown(parts.of_triangle.size());
    std::transform(parts.of_triangle.begin(), parts.of_triangle.end(), shown.begin(),
                   [&](std::uint32_t component) { return of_component[component]; });
    return shown;
}

constexpr std::uint32_t no_component = 0xFFFFFFFF;

/// Whether the inside of the surface lies around the component, as far as its volume tells.
bool is_around(const MeshComponent& c) {
    return c.closed ? c.cavity : c.volume_mm3.value_or(0) < 0;
}

/// Finds the components that cavities belong to: those that bound the same solid. The lines of the
/// grid meet a surface in vertices, and between two neighbors on a line the side does not change.
/// So where the solid lies on the left of a component's leftmost vertex, the next vertex there
/// belongs to a component around the same solid. The same is true on the right.
class CavityOwners {
  public:
    CavityOwners(const WeldedMesh& mesh, const VolumeGrid& grid, MeshComponents& parts,
                 bool is_last_inside, const Pause& pause)
        : mesh_(mesh),
          grid_(grid),
          pause_(pause),
          parts_(parts.components),
          is_last_inside_(is_last_inside),
          has_holes_(std::any_of(parts_.begin(), parts_.end(),
                                 [](const auto& c) { return !c.closed_but_for_border; })),
          of_vertex_(mesh.keys.size(), no_component),
          ends_(parts_.size()) {
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            pause_at(t, pause_);
            for (const std::uint32_t vertex : mesh.triangles[t]) {
                of_vertex_[vertex] = parts.of_triangle[t];
            }
        }
        find_ends();
    }

    void run() {
        const auto count = static_cast<std::uint32_t>(parts_.size());
        DisjointSets solids(count + 1);  // The last is the solid of the volume's first voxel.
        for (std::uint32_t i = 0; i < count; ++i) {
            pause_at(i, pause_, components_per_pause);
            for (const Side side : {left, right}) {
                if (!is_solid_beyond(i, side)) continue;
                const std::uint32_t found = next_component(ends_[i][side], side);
                solids.join(i, found == no_component ? count : found);
            }
        }
        // The largest component of each solid that has the solid within, else the largest open one.
        std::vector<std::uint32_t> owner(count + 1, no_component);
        for (const bool any : {false, true}) {
            for (std::uint32_t i = 0; i < count; ++i) {
                std::uint32_t& known = owner[solids.root(i)];
                const bool can_own = any ? !parts_[i].closed : !is_around(parts_[i]);
                if (known == no_component && can_own) known = i;
            }
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint32_t found = owner[solids.root(i)];
            if (found == no_component || found == i || !is_around(parts_[i])) continue;
            parts_[i].cavity_of = found;
            parts_[i].cavity = true;
        }
    }

  private:
    using Voxel = std::array<int, 3>;
    enum Side : std::size_t { left, right };

    /// The voxels beyond each component's outermost vertices on edges along x.
    void find_ends() {
        for (auto& ends : ends_) {
            ends[left][0] = std::numeric_limits<int>::max();
            ends[right][0] = -1;
        }
        for (std::size_t v = 0; v < mesh_.keys.size(); ++v) {
            pause_at(v, pause_);
            const EdgePlace place = edge_place(mesh_.keys[v], grid_);
            if (place.axis != 0 || of_vertex_[v] == no_component) continue;
            auto& ends = ends_[of_vertex_[v]];
            if (place.voxel[0] < ends[left][0]) ends[left] = place.voxel;
            if (place.voxel[0] >= ends[right][0]) {
                ends[right] = {place.voxel[0] + 1, place.voxel[1], place.voxel[2]};
            }
        }
    }

    /// Whether the solid that a component bounds lies beyond its outermost vertex on a side. Of a
    /// closed one it does if the component is a cavity.
    bool is_solid_beyond(std::uint32_t component, Side side) const {
        if (ends_[component][right][0] < 0) return false;
        if (parts_[component].closed) return parts_[component].cavity;
        return !has_holes_ && is_inside(ends_[component][side]);
    }

    /// The component of the next vertex beyond a voxel. Where the line ends at the border, the way
    /// goes on within the border, to two corners of the volume and along its edges.
    std::uint32_t next_component(Voxel voxel, Side side) const {
        const Voxel size = {grid_.nx, grid_.ny, grid_.nz};
        const bool up = side == right;
        const std::array<std::pair<std::size_t, bool>, 6> legs = {
            {{0, up}, {1, false}, {2, false}, {0, !up}, {1, true}, {2, true}}};
        for (const auto& [axis, upwards] : legs) {
            while (upwards ? voxel[axis] + 1 < size[axis] : voxel[axis] > 0) {
                voxel[axis] -= upwards ? 0 : 1;
                const std::uint32_t found = component_on(voxel, axis);
                if (found != no_component) return found;
                voxel[axis] += upwards ? 1 : 0;
            }
        }
        return no_component;
    }

    /// Counts the vertices on the way to the last voxel.
    bool is_inside(Voxel voxel) const {
        const Voxel size = {grid_.nx, grid_.ny, grid_.nz};
        bool inside = is_last_inside_;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (; voxel[axis] + 1 < size[axis]; ++voxel[axis]) {
                if (component_on(voxel, axis) != no_component) inside = !inside;
            }
        }
        return inside;
    }

    std::uint32_t component_on(const Voxel& voxel, std::size_t axis) const {
        const auto at = [&](std::size_t i) { return static_cast<std::uint64_t>(voxel[i]); };
        const std::uint64_t index =
            at(2) * grid_.slice_voxels() + at(1) * static_cast<std::uint64_t>(grid_.nx) + at(0);
        const std::uint64_t key = 4 * index + axis;
        const auto found = std::lower_bound(mesh_.keys.begin(), mesh_.keys.end(), key);
        if (found == mesh_.keys.end() || *found != key) return no_component;
        return of_vertex_[static_cast<std::size_t>(found - mesh_.keys.begin())];
    }

    const WeldedMesh& mesh_;
    const VolumeGrid& grid_;
    const Pause& pause_;
    std::vector<MeshComponent>& parts_;
    bool is_last_inside_, has_holes_;
    std::vector<std::uint32_t> of_vertex_;
    std::vector<std::array<Voxel, 2>> ends_;
};

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

MeshComponents find_components(const WeldedMesh& mesh, const VolumeGrid& grid, const Pause& pause) {
    const MeshMeasure measure(mesh, grid);
    const EdgeTable edges(mesh, pause);
    DisjointSets pieces(mesh.triangles.size());
    const auto join = [&](std::uint32_t, std::span<const EdgeUse> uses) {
        for (const EdgeUse& use : uses.subspan(1)) {
            pieces.join(uses[0].triangle(), use.triangle());
        }
    };
    edges.for_each(join, pause);
    MeshComponents out;
    out.of_triangle = number_components(pieces, mesh.triangles.size(), out.components);
    std::vector<ComponentSums> sums(out.components.size());
    const auto add_end = [&](std::uint32_t low, std::span<const EdgeUse> uses) {
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
    };
    edges.for_each(add_end, pause);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        pause_at(t, pause);
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
    out.box_mm3 = measure.box_mm3();
    for (std::size_t i = 0; i < sums.size(); ++i) finish(sums[i], measure, out.components[i]);
    if (grid.nx != 0 && std::any_of(out.components.begin(), out.components.end(), is_around)) {
        VolumeSums whole;
        for (const ComponentSums& each : sums) whole.add(each.volume);
        CavityOwners(mesh, grid, out, measure.is_last_voxel_inside(whole), pause).run();
    }
    return out;
}

Shown show_component(const MeshComponents& parts, std::size_t component, Cavities cavities) {
    if (component >= parts.components.size()) {
        throw RequestError(ExitCode::failed, fmt::format("component {}: the surface has {}",
                                                         component + 1, parts.components.size()));
    }
    const bool has_cavities = cavities == Cavities::shown;
    return show_if(parts, [=](std::size_t number, const MeshComponent& c) {
        return number == component || (has_cavities && c.cavity_of == component);
    });
}

std::size_t largest_component(const MeshComponents& parts) {
    const auto found = std::find_if(parts.components.begin(), parts.components.end(),
                                    [](const MeshComponent& c) { return !c.cavity_of; });
    assert(found != parts.components.end());  // A component with a cavity is none itself.
    return static_cast<std::size_t>(found - parts.components.begin());
}

Shown show_at_least(const MeshComponents& parts, ComponentMeasure measure, double least,
                    Cavities cavities) {
    return show_if(parts, [&](std::size_t, const MeshComponent& c) {
        if (!c.cavity_of) return is_at_least(c, measure, least);
        return cavities == Cavities::shown &&
               is_at_least(parts.components[*c.cavity_of], measure, least);
    });
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
