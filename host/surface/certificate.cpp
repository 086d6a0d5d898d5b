#include "host/surface/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/glm.hpp>
#include <numbers>

#include "host/surface/disjoint_sets.hpp"
#include "host/surface/edge_table.hpp"
#include "host/surface/holes.hpp"
#include "host/surface/mesh_measure.hpp"

namespace pxpl5::host {

namespace {

constexpr std::uint32_t none = 0xFFFFFFFF;

/// Goes over the edges, then the vertices, then the triangles.
class Certifier {
  public:
    Certifier(const WeldedMesh& mesh, const VolumeGrid& grid, const Pause& pause)
        : mesh_(mesh), grid_(grid), pause_(pause), measure_(mesh, grid) {}

    Certificate run() {
        out_.has_grid = grid_.nx != 0;
        out_.triangles = static_cast<std::int64_t>(mesh_.triangles.size());
        out_.vertices = static_cast<std::int64_t>(mesh_.keys.size());
        out_.components = out_.triangles;
        look_at_edges();
        look_at_triangles();
        out_.volume_mm3 = mesh_.triangles.empty() ? 0 : measure_.within_box_mm3(volume_);
        return std::move(out_);
    }

  private:
    void look_at_edges() {
        // Corners that meet over an edge are of one fan; a vertex should have one.
        DisjointSets pieces(mesh_.triangles.size()), fans(3 * mesh_.triangles.size());
        std::int64_t fan_count = 3 * out_.triangles;
        const auto look = [&](std::uint32_t low, std::span<const EdgeUse> uses) {
            ++out_.edges;
            look_at_edge(low, uses);
            const EdgeUse& first = uses[0];
            for (const EdgeUse& use : uses.subspan(1)) {
                if (pieces.join(first.triangle(), use.triangle())) --out_.components;
                if (fans.join(first.corner_low(), use.corner_low())) --fan_count;
                if (fans.join(first.corner_high(), use.corner_high())) --fan_count;
            }
        };
        EdgeTable(mesh_, pause_).for_each(look, pause_);
        out_.holes = count_holes(open_, measure_.middles());
        look_at_vertices(fans);
    }

    void look_at_edge(std::uint32_t low, std::span<const EdgeUse> uses) {
        const EdgeUse& first = uses[0];
        if (uses.size() == 1) {
            look_at_boundary(low, first);
            return;
        }
        look_at_balance(low, uses);
        if (uses.size() > 2) {
            add_defect(DefectKind::overfull_edge, {low, first.high, 0}, 2, first.triangle());
        } else if (first.forward() == uses[1].forward()) {
            add_defect(DefectKind::misoriented_edge, {low, first.high, 0}, 2, first.triangle());
        }
        look_for_repeated(low, uses);
    }

    /// Several triangles of a simplified surface may end together at the volume's border.
    void look_at_balance(std::uint32_t low, std::span<const EdgeUse> uses) {
        std::int64_t balance = 0;
        for (const EdgeUse& use : uses) {
            balance += use.forward() ? 1 : -1;
        }
        if (balance == 0) {
            return;
        }
        const std::uint32_t high = uses[0].high;
        if (!is_in_border(low, high)) {
            ++out_.unbalanced_edges;
            return;
        }
        ++out_.border_edges;
        for (std::int64_t i = 0; i < std::abs(balance); ++i) {
            measure_.add_border(balance > 0 ? low : high, balance > 0 ? high : low, volume_);
        }
    }

    bool is_in_border(std::uint32_t a, std::uint32_t b) const {
        const auto& middles = measure_.middles();
        return common_border(middles[a], middles[b], grid_) != 0;
    }

    void look_at_boundary(std::uint32_t low, const EdgeUse& use) {
        if (!is_in_border(low, use.high)) {
            ++out_.unbalanced_edges;
            open_.push_back({low, use.high});
            add_defect(DefectKind::open_edge, {low, use.high, 0}, 2, use.triangle());
            return;
        }
        ++out_.border_edges;
        measure_.add_border(use.forward() ? low : use.high, use.forward() ? use.high : low,
                            volume_);
    }

    /// At the edge of a triangle's two lowest vertices, so that each is found once.
    void look_for_repeated(std::uint32_t low, std::span<const EdgeUse> uses) {
        const auto third = [&](const EdgeUse& use) {
            return corner(next_corner(next_corner(use.tail())));
        };
        for (std::size_t i = 1; i < uses.size(); ++i) {
            const std::uint32_t vertex = third(uses[i]);
            if (vertex <= uses[i].high) continue;
            if (std::any_of(uses.begin(), uses.begin() + static_cast<std::ptrdiff_t>(i),
                            [&](const EdgeUse& use) { return third(use) == vertex; })) {
                add_defect(DefectKind::repeated_triangle, {low, uses[i].high, vertex}, 3,
                           uses[i].triangle());
            }
        }
    }

    void look_at_vertices(DisjointSets& fans) {
        std::vector<std::uint8_t> counts(mesh_.keys.size());
        std::vector<std::uint32_t> pinched;
        for (std::uint32_t c = 0; c < 3 * mesh_.triangles.size(); ++c) {
            pause_at(c, pause_);
            if (fans.root(c) != c) continue;
            std::uint8_t& count = counts[corner(c)];
            if (count == 1) pinched.push_back(c);
            count = static_cast<std::uint8_t>(std::min(count + 1, 2));
        }
        std::sort(pinched.begin(), pinched.end(),
                  [&](auto a, auto b) { return corner(a) < corner(b); });
        for (const std::uint32_t c : pinched) {
            add_defect(DefectKind::pinched_vertex, {corner(c), 0, 0}, 1, c / 3);
        }
        for (std::uint32_t v = 0; v < counts.size(); ++v) {
            if (counts[v] == 0) add_defect(DefectKind::unused_vertex, {v, 0, 0}, 1, none);
        }
    }

    void look_at_triangles() {
        static const double sine = std::sin(sliver_angle_deg * std::numbers::pi / 180);
        double doubled_area = 0;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
            pause_at(t, pause_);
            const auto& [a, b, c] = mesh_.triangles[t];
            if (a == b || b == c || c == a) {
                add_defect(DefectKind::collapsed_triangle, {a, b, c}, 3, t);
            }
            const glm::dvec3 normal = measure_.doubled_normal_grid(t);
            measure_.add_triangle(t, normal, volume_);
            const glm::dvec3 normal_mm2 = measure_.to_mm2(normal);
            const double square = glm::dot(normal_mm2, normal_mm2);
            doubled_area += std::sqrt(square);
            if (normal == glm::dvec3(0)) {
                ++out_.degenerate;
            } else if (square < sine * sine * product_of_longer_sides(t)) {
                ++out_.slivers;
            }
        }
        out_.area_mm2 = doubled_area / 2;
        for (std::uint32_t v = 0; v < mesh_.keys.size(); ++v) out_.bounds_mm.add(measure_.p_mm(v));
    }

    /// Takes squared lengths. The smallest angle is between the two longer sides.
    double product_of_longer_sides(std::uint32_t t) const {
        const auto& [a, b, c] = mesh_.triangles[t];
        const glm::dmat3 m(grid_.voxel_to_patient);
        const auto square = [&](std::uint32_t p, std::uint32_t q) {
            const glm::dvec3 side = m * (measure_.p_grid(q) - measure_.p_grid(p));
            return glm::dot(side, side);
        };
        const double ab = square(a, b), bc = square(b, c), ca = square(c, a);
        return std::max({ab * bc, bc * ca, ca * ab});
    }

    std::uint32_t corner(std::uint32_t c) const { return mesh_.triangles[c / 3][c % 3]; }

    /// triangle  One that is there, or none.
    void add_defect(DefectKind kind, std::array<std::uint32_t, 3> vertices, int count,
                    std::uint32_t triangle) {
        std::int64_t& counted = out_.defect_counts[static_cast<std::size_t>(kind)];
        if (++counted > static_cast<std::int64_t>(max_listed_defects)) return;
        Defect defect;
        defect.kind = kind;
        defect.key_count = count;
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
            defect.keys[i] = mesh_.keys[vertices[i]];
            defect.p_mm += measure_.p_mm(vertices[i]) / static_cast<double>(count);
        }
        if (triangle != none && !mesh_.cells.empty()) defect.cell = mesh_.cells[triangle];
        out_.defects.push_back(defect);
    }

    const WeldedMesh& mesh_;
    const VolumeGrid& grid_;
    const Pause& pause_;
    MeshMeasure measure_;
    VolumeSums volume_;
    std::vector<VertexPair> open_;  ///< Edges off the border.
    Certificate out_;
};

}  // namespace

bool Certificate::manifold() const {
    return count(DefectKind::overfull_edge) == 0 && count(DefectKind::pinched_vertex) == 0 &&
           count(DefectKind::unused_vertex) == 0 && count(DefectKind::repeated_triangle) == 0 &&
           count(DefectKind::collapsed_triangle) == 0;
}

std::optional<std::int64_t> Certificate::genus() const {
    if (triangles == 0 || !closed() || !good()) return std::nullopt;
    return components - euler() / 2;
}

Certificate certify(const WeldedMesh& mesh, const VolumeGrid& grid, const Pause& pause) {
    return Certifier(mesh, grid, pause).run();
}

}  // namespace pxpl5::host
