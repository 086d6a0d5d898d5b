// The only file that includes meshoptimizer.
#include "host/io/mesh/mesh_simplify.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

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

}  // namespace

SimplifiedSurface simplify(const MeshSurface& surface, double keep) {
    assert(keep > 0 && keep <= 1);
    static_assert(sizeof(MeshPoint) == 6 * sizeof(float));
    const std::size_t triangles = surface.indices.size() / 3;
    const auto target =
        static_cast<std::size_t>(std::llround(static_cast<double>(triangles) * keep));
    SimplifiedSurface result = welded(surface);
    if (result.indices.size() <= 3 * target) {
        return result;
    }
    const float* positions = &result.vertices.data()->p_mm.x;
    std::vector<std::uint32_t> fewer(result.indices.size());
    float error = 0;  // Share of the surface's extent.
    const std::size_t left =
        meshopt_simplify(fewer.data(), result.indices.data(), result.indices.size(), positions,
                         result.vertices.size(), sizeof(MeshPoint), 3 * target, most_moved,
                         meshopt_SimplifyLockBorder, &error);
    result.moved_mm =
        static_cast<double>(error) * static_cast<double>(meshopt_simplifyScale(
                                         positions, result.vertices.size(), sizeof(MeshPoint)));
    fewer.resize(left);
    result.indices = std::move(fewer);
    remove_flaps(result.indices);
    compact(result);
    return result;
}

}  // namespace pxpl5::host::io
