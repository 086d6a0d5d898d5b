#include "host/surface/holes.hpp"

#include <algorithm>
#include <cstdlib>
#include <tuple>
#include <vector>

#include "host/surface/disjoint_sets.hpp"

namespace pxpl5::host {

namespace {

/// A face of cells: its middle, doubled, tells it. All zero, where there is no face, for an edge
/// within a cell.
using FacePlace = std::array<int, 3>;

/// Along the face's normal both vertices are at the same voxel; along the other axes each is in the
/// middle or at an end.
FacePlace face_of(const DoubledMiddle& a, const DoubledMiddle& b) {
    for (std::size_t normal = 0; normal < 3; ++normal) {
        if (a[normal] != b[normal] || a[normal] % 2 != 0) continue;
        FacePlace face{};
        bool within = true;
        for (std::size_t i = 0; i < 3; ++i) {
            const int p = a[i], q = b[i];
            face[i] = i == normal || p % 2 != 0 ? p : q % 2 != 0 ? q : (p + q) / 2;
            within = within && (i == normal || (face[i] % 2 != 0 && std::abs(p - face[i]) <= 1 &&
                                                std::abs(q - face[i]) <= 1));
        }
        if (within) return face;
    }
    return {};
}

struct EdgeEnd {
    std::uint32_t vertex = 0;
    FacePlace face{};
    std::uint32_t edge = 0;
};

}  // namespace

std::int64_t count_holes(std::span<const VertexPair> edges,
                         std::span<const DoubledMiddle> middles) {
    std::vector<EdgeEnd> ends;
    ends.reserve(2 * edges.size());
    for (std::uint32_t e = 0; e < edges.size(); ++e) {
        const FacePlace face = face_of(middles[edges[e][0]], middles[edges[e][1]]);
        for (const std::uint32_t vertex : edges[e]) ends.push_back({vertex, face, e});
    }
    std::sort(ends.begin(), ends.end(), [](const EdgeEnd& a, const EdgeEnd& b) {
        return std::tie(a.vertex, a.face, a.edge) < std::tie(b.vertex, b.face, b.edge);
    });
    DisjointSets holes(edges.size());
    auto count = static_cast<std::int64_t>(edges.size());
    for (auto first = ends.begin(); first != ends.end();) {
        const auto last = std::find_if(
            first, ends.end(), [&](const EdgeEnd& end) { return end.vertex != first->vertex; });
        const bool two = last - first == 2;
        for (auto end = first + 1; end != last; ++end) {
            const EdgeEnd& before = *(end - 1);
            if ((two || end->face == before.face) && holes.join(before.edge, end->edge)) --count;
        }
        first = last;
    }
    return count;
}

}  // namespace pxpl5::host
