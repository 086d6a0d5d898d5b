#include "host/io/mesh/mesh_flips.hpp"

#include <algorithm>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <utility>

#include "host/surface/edge_table.hpp"

namespace pxpl5::host::io {

namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Two triangles a, b, c and a, c, d that become a, b, d and b, c, d.
struct Flip {
    std::uint32_t flat = 0, other = 0;  ///< Triangles.
    std::uint32_t a = 0, b = 0, c = 0, d = 0;
};

class Flips {
  public:
    Flips(std::span<const MeshPoint> vertices, std::vector<std::uint32_t>& indices)
        : vertices_(vertices), indices_(indices) {
        mesh_.keys.resize(vertices.size());
    }

    /// Flips one edge per flat triangle where possible. Returns whether an edge was flipped.
    bool run_once() {
        mesh_.triangles.resize(indices_.size() / 3);
        bool has_flat = false;
        is_flat_.assign(mesh_.triangles.size(), false);
        for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
            std::copy_n(indices_.begin() + static_cast<std::ptrdiff_t>(3 * t), 3,
                        mesh_.triangles[t].begin());
            is_flat_[t] = is_flat(vertices_, mesh_.triangles[t]);
            has_flat = has_flat || is_flat_[t];
        }
        if (!has_flat) {
            return false;
        }
        const EdgeTable edges(mesh_);
        find(edges);
        edges.for_each([&](std::uint32_t low, std::span<const EdgeUse> uses) {
            // An edge of more than two triangles otherwise.
            if (flips_.erase({low, uses[0].high}) > 0) {
                refused_.insert({low, uses[0].high});
            }
        });
        for (const auto& [edge, flip] : flips_) {
            put(flip.flat, {flip.a, flip.b, flip.d});
            put(flip.other, {flip.b, flip.c, flip.d});
        }
        return !flips_.empty();
    }

  private:
    /// Collects flips by the edges that they make. No two have a triangle in common.
    void find(const EdgeTable& edges) {
        flips_.clear();
        std::vector<bool> is_taken(mesh_.triangles.size());
        edges.for_each([&](std::uint32_t, std::span<const EdgeUse> uses) {
            if (uses.size() != 2 || uses[0].forward() == uses[1].forward()) {
                return;
            }
            const bool first = is_flat_at_longest(uses[0]);
            if (!first && !is_flat_at_longest(uses[1])) {
                return;
            }
            const EdgeUse &flat = uses[first ? 0 : 1], &other = uses[first ? 1 : 0];
            if (is_taken[flat.triangle()] || is_taken[other.triangle()]) {
                return;
            }
            const Flip flip{flat.triangle(), other.triangle(),    corner(next_corner(flat.tail())),
                            third(flat),     corner(flat.tail()), third(other)};
            const Edge made = std::minmax(flip.b, flip.d);
            if (flip.b != flip.d && !refused_.contains(made) && flips_.emplace(made, flip).second) {
                is_taken[flip.flat] = is_taken[flip.other] = true;
            }
        });
    }

    std::uint32_t corner(std::uint32_t number) const { return indices_[number]; }

    /// The corner of the use's triangle that is not on the edge.
    std::uint32_t third(const EdgeUse& use) const {
        return corner(next_corner(next_corner(use.tail())));
    }

    bool is_flat_at_longest(const EdgeUse& use) const {
        if (!is_flat_[use.triangle()]) {
            return false;
        }
        const glm::dvec3 from(vertices_[corner(use.tail())].p_mm);
        const glm::dvec3 to(vertices_[corner(next_corner(use.tail()))].p_mm);
        const glm::dvec3 middle(vertices_[third(use)].p_mm);
        return glm::dot(from - middle, to - middle) < 0;
    }

    void put(std::uint32_t triangle, const Triangle& corners) {
        std::copy(corners.begin(), corners.end(),
                  indices_.begin() + static_cast<std::ptrdiff_t>(3 * std::size_t{triangle}));
    }

    std::span<const MeshPoint> vertices_;
    std::vector<std::uint32_t>& indices_;
    WeldedMesh mesh_;
    std::vector<bool> is_flat_;
    std::map<Edge, Flip> flips_;
    std::set<Edge> refused_;
};

}  // namespace

bool is_flat(std::span<const MeshPoint> vertices, const Triangle& triangle) {
    const glm::dvec3 a(vertices[triangle[0]].p_mm), b(vertices[triangle[1]].p_mm),
        c(vertices[triangle[2]].p_mm);
    return glm::cross(b - a, c - a) == glm::dvec3(0);
}

void flip_flat_triangles(std::span<const MeshPoint> vertices, std::vector<std::uint32_t>& indices) {
    Flips flips(vertices, indices);
    constexpr int max_passes = 32;  // Neighbors that are flat take one pass each.
    for (int pass = 0; pass < max_passes && flips.run_once(); ++pass) {
    }
}

}  // namespace pxpl5::host::io
