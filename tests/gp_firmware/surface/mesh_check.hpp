// The certificate of a surface: closed, manifold, oriented, and its measures.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <ostream>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::test {

struct Certificate {
    std::size_t vertices = 0, edges = 0, triangles = 0, components = 0;
    std::size_t border_edges = 0;          ///< Open, in a face of the volume: where it ends.
    std::size_t hole_edges = 0;            ///< Open elsewhere.
    std::size_t misoriented_edges = 0;     ///< Two triangles, the same direction.
    std::size_t nonmanifold_edges = 0;     ///< Three triangles or more.
    std::size_t nonmanifold_vertices = 0;  ///< The triangles around are not one fan.
    std::size_t weld_mismatches = 0;       ///< Slabs differ on a shared vertex, or repeat a key.
    std::size_t bad_indices = 0;
    std::uint64_t owned_vertices = 0;  ///< Sum of the slabs' counts.
    double area_mm2 = 0, volume_mm3 = 0;

    long long euler() const {
        return static_cast<long long>(vertices) - static_cast<long long>(edges) +
               static_cast<long long>(triangles);
    }
    std::size_t defects() const {
        return hole_edges + misoriented_edges + nonmanifold_edges + nonmanifold_vertices +
               weld_mismatches + bad_indices;
    }
    bool good() const { return defects() == 0 && owned_vertices == vertices; }
    bool closed() const { return good() && border_edges == 0; }
};

inline std::ostream& operator<<(std::ostream& out, const Certificate& c) {
    return out << c.vertices << " vertices (" << c.owned_vertices << " owned), " << c.triangles
               << " triangles, " << c.components << " components; open edges " << c.border_edges
               << " on the border, " << c.hole_edges << " elsewhere; misoriented "
               << c.misoriented_edges << ", non-manifold " << c.nonmanifold_edges << " edges "
               << c.nonmanifold_vertices << " vertices; weld mismatches " << c.weld_mismatches
               << ", bad indices " << c.bad_indices;
}

/// One mesh of all slabs, vertices welded by their keys.
struct WeldedMesh {
    std::vector<gp::Vertex> vertices;
    std::vector<std::uint64_t> keys;
    std::vector<std::uint32_t> indices;
    std::size_t mismatches = 0, bad_indices = 0;
};

inline WeldedMesh weld(std::span<const gp::SlabMesh> slabs) {
    WeldedMesh welded;
    std::unordered_map<std::uint64_t, std::uint32_t> known;
    for (const gp::SlabMesh& slab : slabs) {
        std::vector<std::uint32_t> renamed;
        const auto first_of_slab = static_cast<std::uint32_t>(welded.vertices.size());
        for (std::size_t i = 0; i < slab.vertices.size(); ++i) {
            const auto next = static_cast<std::uint32_t>(welded.vertices.size());
            const auto [found, added] = known.emplace(slab.keys[i], next);
            renamed.push_back(found->second);
            if (added) {
                welded.vertices.push_back(slab.vertices[i]);
                welded.keys.push_back(slab.keys[i]);
            } else if (found->second >= first_of_slab ||
                       std::memcmp(&welded.vertices[found->second], &slab.vertices[i],
                                   sizeof(gp::Vertex)) != 0) {
                ++welded.mismatches;
            }
        }
        for (const std::uint32_t index : slab.indices) {
            const bool good = index < renamed.size();
            welded.bad_indices += good ? 0 : 1;
            welded.indices.push_back(good ? renamed[index] : 0);
        }
    }
    return welded;
}

/// Which faces of the volume the vertex with this key lies in: bit 0 x low, bit 1 x high, ...
inline unsigned border_faces(std::uint64_t key, const gp::VolumeShape& shape) {
    const int axis = static_cast<int>(key % 4);
    if (axis == 3) return 0;
    const auto nx = static_cast<std::uint64_t>(shape.nx), ny = static_cast<std::uint64_t>(shape.ny);
    const std::uint64_t voxel = key / 4;
    const std::uint64_t place[3] = {voxel % nx, voxel / nx % ny, voxel / nx / ny};
    const int last[3] = {shape.nx - 1, shape.ny - 1, shape.nz - 1};
    unsigned faces = 0;
    for (int i = 0; i < 3; ++i) {
        if (i == axis) continue;
        if (place[i] == 0) faces |= 1U << (2 * i);
        if (place[i] == static_cast<std::uint64_t>(last[i])) faces |= 2U << (2 * i);
    }
    return faces;
}

/// Sets of numbers that are joined pairwise.
class Groups {
  public:
    explicit Groups(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }
    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }
    std::size_t count() {
        std::size_t roots = 0;
        for (std::uint32_t i = 0; i < parent_.size(); ++i) roots += root(i) == i ? 1 : 0;
        return roots;
    }

  private:
    std::vector<std::uint32_t> parent_;
};

struct EdgeUse {
    std::uint64_t ends;                     ///< Lower vertex << 32 | higher vertex.
    std::uint32_t corner_low, corner_high;  ///< Triangle corners at the two ends.
    bool forward;                           ///< From the lower to the higher vertex.
};

inline std::vector<EdgeUse> edge_uses(const WeldedMesh& mesh) {
    std::vector<EdgeUse> uses;
    for (std::uint32_t corner = 0; corner < mesh.indices.size(); ++corner) {
        const std::uint32_t next = corner % 3 == 2 ? corner - 2 : corner + 1;
        const std::uint32_t a = mesh.indices[corner], b = mesh.indices[next];
        const bool forward = a < b;
        uses.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b),
                        forward ? corner : next, forward ? next : corner, forward});
    }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return std::pair(a.ends, a.corner_low) < std::pair(b.ends, b.corner_low);
    });
    return uses;
}

/// Counts one edge by the triangles that use it.
inline void judge_edge(std::span<const EdgeUse> uses, const WeldedMesh& mesh,
                       const gp::VolumeShape& shape, Certificate& out) {
    ++out.edges;
    if (uses.size() > 2) {
        ++out.nonmanifold_edges;
    } else if (uses.size() == 2) {
        if (uses[0].forward == uses[1].forward) ++out.misoriented_edges;
    } else {
        const std::uint64_t low = mesh.keys[uses[0].ends >> 32];
        const std::uint64_t high = mesh.keys[uses[0].ends & 0xFFFFFFFFU];
        const bool border = (border_faces(low, shape) & border_faces(high, shape)) != 0;
        ++(border ? out.border_edges : out.hole_edges);
    }
}

/// Checks the surface that the slabs make up together.
inline Certificate certify(std::span<const gp::SlabMesh> slabs, const gp::VolumeShape& shape) {
    const WeldedMesh mesh = weld(slabs);
    Certificate out;
    out.vertices = mesh.vertices.size();
    out.triangles = mesh.indices.size() / 3;
    out.weld_mismatches = mesh.mismatches;
    out.bad_indices = mesh.bad_indices;
    for (const gp::SlabMesh& slab : slabs) {
        out.area_mm2 += slab.counts.area_mm2;
        out.volume_mm3 += slab.counts.volume_mm3;
        out.owned_vertices += slab.counts.vertices;
    }
    Groups components(mesh.vertices.size()), fans(mesh.indices.size());
    const std::vector<EdgeUse> uses = edge_uses(mesh);
    for (std::size_t first = 0, end = 0; first < uses.size(); first = end) {
        while (end < uses.size() && uses[end].ends == uses[first].ends) ++end;
        judge_edge(std::span(uses).subspan(first, end - first), mesh, shape, out);
        components.join(static_cast<std::uint32_t>(uses[first].ends >> 32),
                        static_cast<std::uint32_t>(uses[first].ends & 0xFFFFFFFFU));
        for (std::size_t i = first + 1; i < end; ++i) {
            fans.join(uses[first].corner_low, uses[i].corner_low);
            fans.join(uses[first].corner_high, uses[i].corner_high);
        }
    }
    out.components = components.count();
    // Corners that meet over shared edges are a fan; a vertex has one, and none is unused.
    std::vector<std::uint32_t> fan_count(mesh.vertices.size());
    for (std::uint32_t corner = 0; corner < mesh.indices.size(); ++corner)
        if (fans.root(corner) == corner) ++fan_count[mesh.indices[corner]];
    out.nonmanifold_vertices = static_cast<std::size_t>(
        std::count_if(fan_count.begin(), fan_count.end(), [](auto n) { return n != 1; }));
    return out;
}

}  // namespace pxpl5::test
