// The only file that includes meshoptimizer.
#include "host/io/mesh/mesh_simplify.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "host/io/mesh/mesh_flips.hpp"
#include "host/surface/disjoint_sets.hpp"
#include "host/surface/edge_table.hpp"
#include "host/surface/mesh_distance.hpp"

namespace pxpl5::host::io {

namespace {

/// How far the surface may move, of its largest extent: what is further off is another surface.
constexpr float most_moved = 0.05F;
constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();

using Triangle = std::array<std::uint32_t, 3>;

/// A surface in which each place has one vertex, without triangles that have no area for that
/// reason. Where a voxel's value is the isovalue, up to six vertices of the grid's edges meet
/// there, and the collapse of edges would go wrong between them.
SimplifiedSurface welded(const MeshSurface& surface) {
    // Places are compared by their bits: adding 0 makes 0 of -0.
    std::vector<glm::vec3> positions;
    positions.reserve(surface.vertices.size());
    for (const MeshPoint& vertex : surface.vertices) {
        positions.push_back(vertex.p_mm + 0.0F);
    }
    std::vector<std::uint32_t> place(positions.size());
    const std::size_t count =
        meshopt_generateVertexRemap(place.data(), surface.indices.data(), surface.indices.size(),
                                    positions.data(), positions.size(), sizeof(glm::vec3));
    SimplifiedSurface result;
    result.vertices.resize(count);
    for (std::size_t index = surface.vertices.size(); index-- > 0;) {
        if (place[index] != unused) {
            result.vertices[place[index]] = surface.vertices[index];  // The first one stays.
        }
    }
    result.indices.reserve(surface.indices.size());
    for (std::size_t first = 0; first < surface.indices.size(); first += 3) {
        const Triangle t = {place[surface.indices[first]], place[surface.indices[first + 1]],
                            place[surface.indices[first + 2]]};
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
            result.indices.insert(result.indices.end(), t.begin(), t.end());
        }
    }
    return result;
}

/// A triangle's corners ascending, and which way it turns.
struct Turn {
    Triangle corners;
    bool is_even = false;
    std::size_t index = 0;
};

Turn turn_of(const std::vector<std::uint32_t>& indices, std::size_t index) {
    Turn turn{{indices[3 * index], indices[3 * index + 1], indices[3 * index + 2]}, true, index};
    Triangle& c = turn.corners;
    for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)}) {
        if (c[static_cast<std::size_t>(a)] > c[static_cast<std::size_t>(b)]) {
            std::swap(c[static_cast<std::size_t>(a)], c[static_cast<std::size_t>(b)]);
            turn.is_even = !turn.is_even;
        }
    }
    return turn;
}

/// Takes away pairs of triangles that lie on each other back to back, which a collapse leaves where
/// three triangles met in a point. What is closed stays closed.
void remove_flaps(std::vector<std::uint32_t>& indices) {
    std::vector<Turn> turns;
    turns.reserve(indices.size() / 3);
    for (std::size_t index = 0; index < indices.size() / 3; ++index) {
        turns.push_back(turn_of(indices, index));
    }
    std::sort(turns.begin(), turns.end(), [](const Turn& a, const Turn& b) {
        return a.corners != b.corners ? a.corners < b.corners : a.index < b.index;
    });
    std::vector<bool> is_flap(indices.size() / 3);
    for (std::size_t at = 0; at + 1 < turns.size(); ++at) {
        const Turn &a = turns[at], &b = turns[at + 1];
        if (a.corners == b.corners && a.is_even != b.is_even && !is_flap[a.index]) {
            is_flap[a.index] = is_flap[b.index] = true;
        }
    }
    std::size_t kept = 0;
    for (std::size_t index = 0; index < is_flap.size(); ++index) {
        if (!is_flap[index]) {
            std::copy_n(indices.begin() + static_cast<std::ptrdiff_t>(3 * index), 3,
                        indices.begin() + static_cast<std::ptrdiff_t>(3 * kept++));
        }
    }
    indices.resize(3 * kept);
}

/// Drops vertices that no triangle has; the others keep their order.
void compact(SimplifiedSurface& surface) {
    std::vector<std::uint32_t> number(surface.vertices.size(), unused);
    for (const std::uint32_t index : surface.indices) {
        number[index] = 0;
    }
    std::uint32_t count = 0;
    for (std::size_t index = 0; index < number.size(); ++index) {
        if (number[index] != unused) {
            surface.vertices[count] = surface.vertices[index];
            number[index] = count++;
        }
    }
    surface.vertices.resize(count);
    for (std::uint32_t& index : surface.indices) {
        index = number[index];
    }
}

std::vector<Triangle> triangles_of(const std::vector<std::uint32_t>& indices) {
    std::vector<Triangle> triangles(indices.size() / 3);
    for (std::size_t i = 0; i < indices.size(); ++i) {
        triangles[i / 3][i % 3] = indices[i];
    }
    return triangles;
}

std::vector<glm::vec3> places_of(const SimplifiedSurface& surface) {
    std::vector<glm::vec3> all;
    all.reserve(surface.vertices.size());
    for (const MeshPoint& vertex : surface.vertices) {
        all.push_back(vertex.p_mm);
    }
    return all;
}

/// Vertices where the surface is no manifold: on an edge of more than two triangles, or between
/// fans of triangles that share nothing but the vertex.
std::vector<bool> bad_vertices(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
    WeldedMesh mesh;
    mesh.keys.resize(vertices);
    mesh.triangles = triangles_of(indices);
    std::vector<bool> bad(vertices);
    DisjointSets fans(indices.size());
    EdgeTable(mesh).for_each([&](std::uint32_t low, std::span<const EdgeUse> uses) {
        if (uses.size() > 2) {
            bad[low] = bad[uses[0].high] = true;
        }
        for (const EdgeUse& use : uses.subspan(1)) {
            fans.join(uses[0].corner_low(), use.corner_low());
            fans.join(uses[0].corner_high(), use.corner_high());
        }
    });
    std::vector<bool> has_fan(vertices);
    for (std::uint32_t corner = 0; corner < indices.size(); ++corner) {
        if (fans.root(corner) == corner) {
            bad[indices[corner]] = bad[indices[corner]] || has_fan[indices[corner]];
            has_fan[indices[corner]] = true;
        }
    }
    return bad;
}

/// Corners of triangles without area.
std::vector<bool> flat_vertices(const SimplifiedSurface& surface,
                                const std::vector<std::uint32_t>& indices) {
    std::vector<bool> flat(surface.vertices.size());
    for (const Triangle& t : triangles_of(indices)) {
        if (is_flat(surface.vertices, t)) {
            flat[t[0]] = flat[t[1]] = flat[t[2]] = true;
        }
    }
    return flat;
}

/// Triangles that decimation leaves alone, because what it made of them was no manifold or had no
/// area.
class Frozen {
  public:
    explicit Frozen(const SimplifiedSurface& whole)
        : whole_(whole),
          is_frozen_(whole.indices.size() / 3),
          bad_before_(bad_vertices(whole.indices, whole.vertices.size())),
          flat_before_(flat_vertices(whole, whole.indices)) {}

    /// Freezes the triangles around vertices that have become bad. Returns whether there are some.
    bool add_bad(const std::vector<std::uint32_t>& simplified, int rings) {
        return add(bad_vertices(simplified, whole_.vertices.size()), bad_before_, rings);
    }

    /// Freezes the triangles around triangles that have lost their area. Returns whether there are
    /// some.
    bool add_flat(const std::vector<std::uint32_t>& simplified, int rings) {
        return add(flat_vertices(whole_, simplified), flat_before_, rings);
    }

    /// Freezes the triangles around vertices that are farther than `most_mm` from what is left.
    /// Returns whether there are some.
    bool add_far(const std::vector<std::uint32_t>& simplified, double most_mm, int rings) {
        const std::vector<glm::vec3> all = places_of(whole_);
        std::vector<bool> far;
        for (const double distance : distances(all, all, triangles_of(simplified))) {
            far.push_back(distance > most_mm);
        }
        return add(std::move(far), std::vector<bool>(all.size()), rings);
    }

    /// Corners of the triangles that are frozen, or of the others.
    std::vector<std::uint32_t> indices(bool frozen) const {
        std::vector<std::uint32_t> some;
        for (std::size_t i = 0; i < whole_.indices.size(); ++i) {
            if (is_frozen_[i / 3] == frozen) {
                some.push_back(whole_.indices[i]);
            }
        }
        return some;
    }

  private:
    /// Freezes the triangles around vertices that were not there before, and those around these.
    bool add(std::vector<bool> near, const std::vector<bool>& before, int rings) {
        bool has_bad = false;
        for (std::size_t v = 0; v < near.size(); ++v) {
            near[v] = near[v] && !before[v];
            has_bad = has_bad || near[v];
        }
        for (int ring = 0; has_bad && ring < rings; ++ring) {
            std::vector<bool> next = near;
            for (std::size_t t = 0; t < is_frozen_.size(); ++t) {
                const auto corner = [&](std::size_t i) { return whole_.indices[3 * t + i]; };
                if (near[corner(0)] || near[corner(1)] || near[corner(2)]) {
                    is_frozen_[t] = true;
                    next[corner(0)] = next[corner(1)] = next[corner(2)] = true;
                }
            }
            near = std::move(next);
        }
        return has_bad;
    }

    const SimplifiedSurface& whole_;
    std::vector<bool> is_frozen_;
    std::vector<bool> bad_before_, flat_before_;
};

double farthest_vertex_mm(const SimplifiedSurface& whole, const SimplifiedSurface& fewer) {
    return fewer.indices.empty()
               ? 0
               : farthest_distance(places_of(whole), places_of(fewer), triangles_of(fewer.indices));
}

}  // namespace

SimplifiedSurface simplify(const MeshSurface& surface, double keep, double error_mm) {
    assert(keep >= 0 && keep <= 1 && error_mm >= 0);
    static_assert(sizeof(MeshPoint) == 6 * sizeof(float));
    const std::size_t triangles = surface.indices.size() / 3;
    const auto target =
        3 * static_cast<std::size_t>(std::llround(static_cast<double>(triangles) * keep));
    SimplifiedSurface whole = welded(surface);
    if (whole.indices.size() <= target) {
        return whole;
    }
    const float* positions = &whole.vertices.data()->p_mm.x;
    const auto extent_mm = static_cast<double>(
        meshopt_simplifyScale(positions, whole.vertices.size(), sizeof(MeshPoint)));
    const bool has_bound = error_mm > 0;
    const double usual_mm = double{most_moved} * extent_mm;
    const double most_mm = has_bound ? std::min(error_mm, usual_mm) : usual_mm;
    Frozen frozen(whole);
    // meshoptimizer's estimates are below the distances.
    float limit = most_mm < usual_mm ? static_cast<float>(most_mm / extent_mm) : most_moved;
    std::optional<SimplifiedSurface> flat;  // A manifold with triangles without area.
    constexpr int max_nearer = 3;
    const int max_rounds = has_bound ? 24 : 8;
    for (int round = 1, nearer = 0; round <= max_rounds; ++round) {
        SimplifiedSurface result{whole.vertices, frozen.indices(true)};
        const std::vector<std::uint32_t> others = frozen.indices(false);
        const std::size_t wanted = target - std::min(target, result.indices.size());
        std::vector<std::uint32_t> fewer(others.size());
        fewer.resize(meshopt_simplify(fewer.data(), others.data(), others.size(), positions,
                                      whole.vertices.size(), sizeof(MeshPoint), wanted, limit,
                                      meshopt_SimplifyLockBorder, nullptr));
        result.indices.insert(result.indices.end(), fewer.begin(), fewer.end());
        remove_flaps(result.indices);
        flip_flat_triangles(result.vertices, result.indices);
        if (has_bound && result.indices.empty()) {
            limit /= 2;  // Nothing is left that a vertex could be near to.
            continue;
        }
        const bool has_flat = frozen.add_flat(result.indices, round + 1);
        if (frozen.add_bad(result.indices, round + 1)) {
            continue;
        }
        if (has_bound && frozen.add_far(result.indices, most_mm, 1)) {
            limit *= 0.8F;
            continue;
        }
        compact(result);
        result.moved_mm = farthest_vertex_mm(whole, result);
        const bool is_near = result.moved_mm <= most_mm || (!has_bound && ++nearer > max_nearer);
        if (is_near && !has_flat) {
            return result;
        }
        if (is_near && !flat) {
            flat = std::move(result);
        } else if (!is_near) {
            limit *= static_cast<float>(0.9 * most_mm / result.moved_mm);
        }
    }
    // Rather all triangles than a surface that is connected in another way.
    return flat ? *std::move(flat) : whole;
}

}  // namespace pxpl5::host::io
