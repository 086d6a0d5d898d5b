#include "gp_firmware/surface/cluster_block.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <limits>
#include <vector>

#include "gp_firmware/surface/edge_vertex.hpp"

namespace pxpl5::gp {

namespace {

constexpr double fixed_one = 1 << 20;  ///< One voxel in the sums of positions.
constexpr std::uint32_t no_cluster = std::numeric_limits<std::uint32_t>::max();

/// Sums over the vertices of a cell. Integers make them independent of the order.
struct Cluster {
    std::array<std::int64_t, 3> place{}, normal{};
    std::int64_t count = 0;
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};
    std::uint64_t key = std::numeric_limits<std::uint64_t>::max();  ///< The lowest.
    std::array<std::int16_t, 3> normal_of_key{};
};

/// The place of a vertex in the grid, from its key.
struct KeyPlace {
    int x, y, z, axis;
};

/// Numbers the cells of a block along each axis: 0 is the first face (or slice), `last` the last
/// one, and the numbers between are the cells.
struct CellAxis {
    int first, end, side;  ///< Slices of voxels: first .. end, both included.

    int last() const { return (end - first + side - 1) / side + 1; }
    int cell(int place, bool across) const {
        if (across && place == first) {
            return 0;
        }
        return across && place == end ? last() : 1 + (place - first) / side;
    }
};

class Clusters {
  public:
    Clusters(const VolumeShape& shape, int first_slab, int end_slab, int side)
        : nx_(static_cast<std::uint64_t>(shape.nx)),
          ny_(static_cast<std::uint64_t>(shape.ny)),
          x_{0, shape.nx - 1, side},
          y_{0, shape.ny - 1, side},
          z_{first_slab, end_slab, side} {
        numbers_.assign(cells(x_) * cells(y_) * cells(z_), no_cluster);
    }

    KeyPlace place(std::uint64_t key) const {
        const std::uint64_t voxel = key / 4;
        return {static_cast<int>(voxel % nx_), static_cast<int>(voxel / nx_ % ny_),
                static_cast<int>(voxel / nx_ / ny_), static_cast<int>(key % 4)};
    }

    /// Returns the number of the vertex's cluster, which is new if its cell was empty.
    std::uint32_t number(const KeyPlace& p) {
        const bool centered = p.axis == 3;  // Inside a cell of voxels, so in no face.
        const int x = x_.cell(p.x, !centered && p.axis != 0);
        const int y = y_.cell(p.y, !centered && p.axis != 1);
        const int z = z_.cell(p.z, !centered && p.axis != 2);
        const std::size_t row =
            static_cast<std::size_t>(z) * cells(y_) + static_cast<std::size_t>(y);
        std::uint32_t& number = numbers_[row * cells(x_) + static_cast<std::size_t>(x)];
        if (number == no_cluster) {
            number = static_cast<std::uint32_t>(clusters.size());
            clusters.emplace_back();
        }
        return number;
    }

    /// Two slabs have the vertices of the slice between them. The upper slab's are counted.
    bool counts(const KeyPlace& p, int slab) const {
        return p.z == slab || p.z == z_.end || p.axis >= 2;
    }

    std::vector<Cluster> clusters;

  private:
    static std::size_t cells(const CellAxis& axis) {
        return static_cast<std::size_t>(axis.last()) + 1;
    }

    std::uint64_t nx_, ny_;
    CellAxis x_, y_, z_;
    std::vector<std::uint32_t> numbers_;
};

void add(const Vertex& vertex, std::uint64_t key, Cluster& cluster) {
    for (int i = 0; i < 3; ++i) {
        const auto c = static_cast<std::size_t>(i);
        cluster.place[c] += std::llround(double{vertex.p_voxel[i]} * fixed_one);
        cluster.normal[c] += vertex.normal[c];
        cluster.low[i] = std::min(cluster.low[i], vertex.p_voxel[i]);
        cluster.high[i] = std::max(cluster.high[i], vertex.p_voxel[i]);
    }
    ++cluster.count;
    if (key < cluster.key) {
        cluster.key = key;
        cluster.normal_of_key = vertex.normal;
    }
}

Vertex mean(const Cluster& cluster) {
    assert(cluster.count > 0);
    Vertex vertex{};
    glm::vec3 normal;
    for (int i = 0; i < 3; ++i) {
        const auto c = static_cast<std::size_t>(i);
        const double place = static_cast<double>(cluster.place[c]) /
                             (fixed_one * static_cast<double>(cluster.count));
        // Limits keep a vertex in its slice or face to the last bit.
        vertex.p_voxel[i] = std::clamp(static_cast<float>(place), cluster.low[i], cluster.high[i]);
        normal[i] = static_cast<float>(cluster.normal[c]);
    }
    const float length_squared = normal.x * normal.x + normal.y * normal.y + normal.z * normal.z;
    vertex.normal =
        length_squared > 0 ? pack_normal(normal, length_squared) : cluster.normal_of_key;
    return vertex;
}

/// A triangle between clusters, with the lowest one first and a <= b <= c.
struct Triangle {
    std::uint32_t a, b, c;
    int sign;  ///< 1: a, b, c is counter-clockwise seen from outside; -1: a, c, b is.

    bool same_corners(const Triangle& other) const {
        return a == other.a && b == other.b && c == other.c;
    }
};

Triangle sorted(std::array<std::uint32_t, 3> corners) {
    std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
    return corners[1] < corners[2] ? Triangle{corners[0], corners[1], corners[2], 1}
                                   : Triangle{corners[0], corners[2], corners[1], -1};
}

/// Writes the triangles that are left after opposite ones have gone in pairs.
void write_triangles(std::vector<Triangle>& triangles, SlabMesh& out) {
    std::ranges::sort(triangles, [](const Triangle& l, const Triangle& r) {
        return std::array{l.a, l.b, l.c} < std::array{r.a, r.b, r.c};
    });
    for (std::size_t first = 0, end = 0; first < triangles.size(); first = end) {
        const Triangle& t = triangles[first];
        int sum = 0;
        for (; end < triangles.size() && triangles[end].same_corners(t); ++end) {
            sum += triangles[end].sign;
        }
        for (int i = 0; i < std::abs(sum); ++i) {
            out.indices.insert(out.indices.end(), {t.a, sum > 0 ? t.b : t.c, sum > 0 ? t.c : t.b});
        }
    }
}

/// Removes vertices without triangles. The others keep their order.
void drop_unused(SlabMesh& out) {
    std::vector<std::uint32_t> renamed(out.vertices.size(), no_cluster);
    for (const std::uint32_t index : out.indices) {
        renamed[index] = 0;
    }
    std::uint32_t kept = 0;
    for (std::size_t i = 0; i < renamed.size(); ++i) {
        if (renamed[i] != no_cluster) {
            out.vertices[kept] = out.vertices[i];
            out.keys[kept] = out.keys[i];
            renamed[i] = kept++;
        }
    }
    out.vertices.resize(kept);
    out.keys.resize(kept);
    for (std::uint32_t& index : out.indices) {
        index = renamed[index];
    }
}

}  // namespace

double cluster_block(const VolumeShape& shape, std::span<const SlabMesh> slabs,
                     std::span<const SlabMask> hidden, int side, SlabMesh& out) {
    assert(hidden.empty() || hidden.size() == slabs.size());
    assert(side == 2 || side == 4 || side == 8);
    assert(!slabs.empty() && slabs.front().slab % block_slabs == 0);
    const int first = slabs.front().slab, end = std::min(first + block_slabs, shape.slab_count());
    assert(static_cast<int>(slabs.size()) == end - first);
    Clusters grid(shape, first, end, side);
    std::vector<std::vector<std::uint32_t>> numbers;
    for (const SlabMesh& mesh : slabs) {
        assert(mesh.slab == first + static_cast<int>(numbers.size()));
        std::vector<std::uint32_t>& of_slab = numbers.emplace_back();
        of_slab.reserve(mesh.vertices.size());
        for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
            const KeyPlace place = grid.place(mesh.keys[i]);
            const std::uint32_t number = of_slab.emplace_back(grid.number(place));
            if (grid.counts(place, mesh.slab)) {
                add(mesh.vertices[i], mesh.keys[i], grid.clusters[number]);
            }
        }
    }

    out = SlabMesh{};
    out.slab = first;
    for (const Cluster& cluster : grid.clusters) {
        out.vertices.push_back(mean(cluster));
        out.keys.push_back(cluster.key);
    }
    const glm::dmat3 to_mm(shape.voxel_to_patient);
    double moved_squared = 0;
    std::vector<Triangle> triangles;
    for (std::size_t s = 0; s < slabs.size(); ++s) {
        const std::vector<std::uint32_t>& number = numbers[s];
        for (std::size_t i = 0; i < number.size(); ++i) {
            const glm::dvec3 to(out.vertices[number[i]].p_voxel);
            const glm::dvec3 moved = to_mm * (to - glm::dvec3(slabs[s].vertices[i].p_voxel));
            moved_squared = std::max(moved_squared, glm::dot(moved, moved));
        }
        const std::vector<std::uint32_t>& corners = slabs[s].indices;
        for (std::size_t i = 0; i < corners.size(); i += 3) {
            if (!hidden.empty() && is_hidden(hidden[s], i / 3)) {
                continue;
            }
            const Triangle t =
                sorted({number[corners[i]], number[corners[i + 1]], number[corners[i + 2]]});
            if (t.a != t.b && t.b != t.c) {
                triangles.push_back(t);
            }
        }
    }
    write_triangles(triangles, out);
    drop_unused(out);
    out.counts.triangles = static_cast<std::uint32_t>(out.indices.size() / 3);
    return std::sqrt(moved_squared);
}

}  // namespace pxpl5::gp
