#include "host/surface/export/border_cap.hpp"

#include <algorithm>
#include <array>
#include <glm/glm.hpp>
#include <unordered_map>
#include <unordered_set>

#include "host/surface/edge_table.hpp"
#include "host/surface/mesh_measure.hpp"
#include "host/volume/typed_values.hpp"

namespace pxpl5::host {

namespace {

using Voxel = std::array<int, 3>;
constexpr std::uint32_t no_vertex = 0xFFFFFFFF;

/// A square of a face: its corners 0..3 one after the other, and the crossings behind each.
struct Square {
    std::array<Voxel, 4> corners{};
    std::array<std::uint32_t, 4> crossings{};  ///< Vertices of the mesh, or no_vertex.
};

class BorderCap {
  public:
    BorderCap(WeldedMesh& mesh, const Volume& volume, double isovalue)
        : mesh_(mesh), volume_(volume), grid_(grid_of(volume)), isovalue_(isovalue) {
        is_mirrored_ = glm::determinant(glm::dmat3(grid_.voxel_to_patient)) < 0;
        keys_ = mesh.keys;
    }

    void run() {
        find_open_edges();
        if (open_.empty()) return;
        find_sides();
        for (int axis = 0; axis < 3; ++axis) {
            cap_face(axis, false);
            cap_face(axis, true);
        }
    }

  private:
    int count(int axis) const { return axis == 0 ? grid_.nx : axis == 1 ? grid_.ny : grid_.nz; }

    std::uint64_t index_of(const Voxel& v) const {
        return (static_cast<std::uint64_t>(v[2]) * static_cast<std::uint64_t>(grid_.ny) +
                static_cast<std::uint64_t>(v[1])) *
                   static_cast<std::uint64_t>(grid_.nx) +
               static_cast<std::uint64_t>(v[0]);
    }

    static std::uint64_t pair_of(std::uint32_t from, std::uint32_t to) {
        return std::uint64_t{from} << 32 | to;
    }

    void find_open_edges() {
        const std::vector<DoubledMiddle> middles = doubled_middles(mesh_, grid_);
        EdgeTable(mesh_).for_each([&](std::uint32_t low, std::span<const EdgeUse> uses) {
            const std::uint32_t high = uses[0].high;
            if (uses.size() == 1 && common_border(middles[low], middles[high], grid_) != 0) {
                const bool forward = uses[0].forward();
                open_.insert(forward ? pair_of(low, high) : pair_of(high, low));
                first_ = low;
            }
        });
    }

    /// The vertex on the edge from `voxel` along `axis`.
    std::uint32_t vertex_on(const Voxel& voxel, int axis) const {
        const std::uint64_t key = 4 * index_of(voxel) + static_cast<std::uint64_t>(axis);
        const auto at = std::lower_bound(keys_.begin(), keys_.end(), key);
        return at == keys_.end() || *at != key ? no_vertex
                                               : static_cast<std::uint32_t>(at - keys_.begin());
    }

    bool is_on_border(const Voxel& v, int axis) const {
        const int at = v[static_cast<std::size_t>(axis)];
        return at == 0 || at == count(axis) - 1;
    }

    bool is_at_least_isovalue(const Voxel& voxel) const {
        bool inside = false;
        with_values(volume_, [&](auto values) {
            inside = static_cast<double>(values[index_of(voxel)]) >= isovalue_;
        });
        return inside;
    }

    /// On which side of the surface each voxel of the faces lies: another one across each vertex.
    /// Components that were left out have no vertices, so they have no inside either.
    void find_sides() {
        const Voxel start = edge_place(keys_[first_], grid_).voxel;
        std::vector<Voxel> waiting = {start};
        is_inside_[index_of(start)] = is_at_least_isovalue(start);
        while (!waiting.empty()) {
            const Voxel at = waiting.back();
            waiting.pop_back();
            const bool inside = is_inside_.at(index_of(at));
            for (int axis = 0; axis < 3; ++axis) {
                if (!is_on_border(at, (axis + 1) % 3) && !is_on_border(at, (axis + 2) % 3)) {
                    continue;  // The edge along this axis leaves the border.
                }
                for (const int step : {-1, 1}) {
                    Voxel next = at;
                    int& place = next[static_cast<std::size_t>(axis)];
                    place += step;
                    if (place < 0 || place >= count(axis)) continue;
                    const bool crosses = vertex_on(step > 0 ? at : next, axis) != no_vertex;
                    if (is_inside_.emplace(index_of(next), inside != crosses).second) {
                        waiting.push_back(next);
                    }
                }
            }
        }
    }

    void cap_face(int axis, bool is_high) {
        const auto normal = static_cast<std::size_t>(axis);
        const std::size_t u = (normal + 1) % 3, v = (normal + 2) % 3;
        // The corners go around the axis; the face's outer side is the other one at its low end.
        const bool is_reversed = is_high == is_mirrored_;
        Voxel at{};
        at[normal] = is_high ? count(axis) - 1 : 0;
        for (at[v] = 0; at[v] + 1 < count(static_cast<int>(v)); ++at[v]) {
            for (at[u] = 0; at[u] + 1 < count(static_cast<int>(u)); ++at[u]) {
                Square square;
                square.corners.fill(at);
                ++square.corners[1][u], ++square.corners[2][u];
                ++square.corners[2][v], ++square.corners[3][v];
                const int along_u = static_cast<int>(u), along_v = static_cast<int>(v);
                square.crossings = {
                    vertex_on(square.corners[0], along_u), vertex_on(square.corners[1], along_v),
                    vertex_on(square.corners[3], along_u), vertex_on(square.corners[0], along_v)};
                cap_square(square, is_reversed);
            }
        }
    }

    void cap_square(const Square& square, bool is_reversed) {
        std::array<bool, 4> left{};
        for (std::size_t c = 0; c < 4; ++c) {
            left[c] = is_inside_.at(index_of(square.corners[c]));
        }
        for (std::size_t c = 0; c < 4; ++c) {
            if (!left[c]) continue;
            const std::vector<std::uint32_t> polygon = inside_from(square, c, is_reversed, left);
            for (std::size_t i = 2; i < polygon.size(); ++i) {
                // All its points lie on the square's sides, so it is convex.
                mesh_.triangles.push_back({polygon[0], polygon[is_reversed ? i : i - 1],
                                           polygon[is_reversed ? i - 1 : i]});
            }
        }
    }

    /// The polygon around the inside of a square from an inside corner on, along the sides and the
    /// surface's open edges; its corners are taken out of `left`. Empty where an edge is missing.
    std::vector<std::uint32_t> inside_from(const Square& square, std::size_t first,
                                           bool is_reversed, std::array<bool, 4>& left) {
        std::vector<std::uint32_t> polygon;
        std::size_t corner = first;
        do {
            left[corner] = false;
            polygon.push_back(corner_vertex(square.corners[corner]));
            const std::uint32_t exit = square.crossings[corner];
            if (exit != no_vertex) {
                const auto entry = std::find_if(
                    square.crossings.begin(), square.crossings.end(), [&](std::uint32_t other) {
                        return other != no_vertex &&
                               open_.contains(is_reversed ? pair_of(exit, other)
                                                          : pair_of(other, exit));
                    });
                if (entry == square.crossings.end()) return {};
                polygon.insert(polygon.end(), {exit, *entry});
                corner = static_cast<std::size_t>(entry - square.crossings.begin());
            }
            corner = (corner + 1) % 4;
        } while (corner != first && left[corner]);
        return polygon;
    }

    std::uint32_t corner_vertex(const Voxel& voxel) {
        const auto next = static_cast<std::uint32_t>(mesh_.keys.size());
        const auto [at, is_new] = corners_.emplace(index_of(voxel), next);
        if (is_new) {
            glm::dvec3 outwards(0);
            for (int axis = 0; axis < 3; ++axis) {
                if (is_on_border(voxel, axis)) {
                    outwards[axis] = voxel[static_cast<std::size_t>(axis)] == 0 ? -1 : 1;
                }
            }
            const glm::dvec3 normal = cofactors(grid_) * outwards * (is_mirrored_ ? -1.0 : 1.0);
            mesh_.keys.push_back(~std::uint64_t{0} - at->first);
            mesh_.p_grid.emplace_back(voxel[0], voxel[1], grid_.place(voxel[2]));
            mesh_.normals.emplace_back(glm::normalize(normal));
        }
        return at->second;
    }

    WeldedMesh& mesh_;
    const Volume& volume_;
    VolumeGrid grid_;
    double isovalue_;
    bool is_mirrored_ = false;
    std::vector<std::uint64_t> keys_;         ///< Keys of the surface, without new vertices.
    std::unordered_set<std::uint64_t> open_;  ///< In the direction of their triangle.
    std::uint32_t first_ = 0;                 ///< A vertex in a face of the volume.
    std::unordered_map<std::uint64_t, bool> is_inside_;
    std::unordered_map<std::uint64_t, std::uint32_t> corners_;  ///< New vertices by voxel.
};

}  // namespace

void cap_at_border(WeldedMesh& mesh, const Volume& volume, double isovalue) {
    BorderCap(mesh, volume, isovalue).run();
    mesh.cells.clear();
}

}  // namespace pxpl5::host
