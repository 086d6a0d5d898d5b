#include "host/surface/edge_table.hpp"

#include <algorithm>
#include <cassert>

namespace pxpl5::host {

namespace {

/// Calls visit(tail corner, from, to) for each side of each triangle.
template <class Visit>
void for_each_side(const WeldedMesh& mesh, const Pause& pause, Visit visit) {
    std::uint32_t corner = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        pause_at(t, pause);
        const auto& [a, b, c] = mesh.triangles[t];
        if (a != b) visit(corner, a, b);
        if (b != c) visit(corner + 1, b, c);
        if (c != a) visit(corner + 2, c, a);
        corner += 3;
    }
}

bool precedes(const EdgeUse& a, const EdgeUse& b) {
    return a.high != b.high ? a.high < b.high : a.packed < b.packed;
}

/// By insertion where there are few, as there are in a surface.
void sort_uses(std::span<EdgeUse> uses) {
    constexpr std::size_t few = 32;
    if (uses.size() > few) {
        std::sort(uses.begin(), uses.end(), precedes);
        return;
    }
    for (std::size_t i = 1; i < uses.size(); ++i) {
        const EdgeUse use = uses[i];
        std::size_t j = i;
        for (; j > 0 && precedes(use, uses[j - 1]); --j) uses[j] = uses[j - 1];
        uses[j] = use;
    }
}

}  // namespace

EdgeTable::EdgeTable(const WeldedMesh& mesh, const Pause& pause) : starts_(mesh.keys.size() + 2) {
    assert(mesh.triangles.size() <= max_triangles);
    for_each_side(mesh, pause, [&](std::uint32_t, std::uint32_t from, std::uint32_t to) {
        assert(std::max(from, to) < mesh.keys.size());
        ++starts_[std::min(from, to) + 2];
    });
    for (std::size_t i = 2; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    uses_.resize(starts_.back());
    // Filling moves each vertex' start, which lies one place further for now, to its end.
    for_each_side(mesh, pause, [&](std::uint32_t corner, std::uint32_t from, std::uint32_t to) {
        const bool forward = from < to;
        uses_[starts_[std::min(from, to) + 1]++] = {std::max(from, to),
                                                    2 * corner + (forward ? 1U : 0U)};
    });
    starts_.pop_back();
    for (std::size_t v = 0; v + 1 < starts_.size(); ++v) {
        pause_at(v, pause);
        sort_uses(std::span(uses_).subspan(starts_[v], starts_[v + 1] - starts_[v]));
    }
}

}  // namespace pxpl5::host
