// The edges of a mesh with the triangles at each.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/surface/pauses.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// The corner that follows in its triangle; corner c is corner c % 3 of triangle c / 3.
constexpr std::uint32_t next_corner(std::uint32_t corner) {
    return corner % 3 == 2 ? corner - 2 : corner + 1;
}

/// A triangle's use of an edge.
struct EdgeUse {
    std::uint32_t high = 0;    ///< The edge's higher vertex.
    std::uint32_t packed = 0;  ///< 2 * corner that it leaves + 1 if it leaves the lower vertex.

    bool forward() const { return (packed & 1) != 0; }  ///< From the lower to the higher vertex.
    std::uint32_t triangle() const { return packed / 6; }
    std::uint32_t tail() const { return packed / 2; }  ///< The triangle's corner that it leaves.
    std::uint32_t corner_low() const { return forward() ? tail() : next_corner(tail()); }
    std::uint32_t corner_high() const { return forward() ? next_corner(tail()) : tail(); }
};

/// All edges, sorted by their lower, then their higher vertex. Memory: 8 bytes for each side of a
/// triangle, 4 for each vertex.
class EdgeTable {
  public:
    static constexpr std::size_t max_triangles = 0xFFFFFFFFU / 6;

    /// mesh  At most max_triangles; indices below the number of keys. Both are asserted.
    explicit EdgeTable(const WeldedMesh& mesh, const Pause& pause = {});

    /// Calls visit(low vertex, uses) for each edge; uses ascend by triangle. A triangle with a
    /// vertex twice has no side from that vertex to itself.
    template <class Visit>
    void for_each(Visit visit, const Pause& pause = {}) const {
        for (std::uint32_t low = 0; low + 1 < starts_.size(); ++low) {
            pause_at(low, pause);
            const std::uint32_t end = starts_[low + 1];
            for (std::uint32_t first = starts_[low], next = first; first < end; first = next) {
                while (next < end && uses_[next].high == uses_[first].high) ++next;
                visit(low, std::span(uses_).subspan(first, next - first));
            }
        }
    }

  private:
    std::vector<std::uint32_t> starts_;  ///< Start of each lower vertex' uses.
    std::vector<EdgeUse> uses_;
};

}  // namespace pxpl5::host
