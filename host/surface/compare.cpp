#include "host/surface/compare.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "host/base/error.hpp"
#include "host/surface/certificate.hpp"

namespace pxpl5::host {

namespace {

using CellPlace = std::tuple<std::uint16_t, std::uint16_t, std::uint16_t>;

/// In the order of extraction.
CellPlace place_of(const MeshCell& cell) {
    return {cell.k, cell.j, cell.i};
}

/// The triangles [first, end) of one cell.
struct CellTriangles {
    std::size_t first = 0, end = 0;
};

/// Goes over a mesh cell by cell.
class CellWalk {
  public:
    explicit CellWalk(const WeldedMesh& mesh) : mesh_(mesh) { find_end(); }

    bool done() const { return range_.first == mesh_.triangles.size(); }
    const MeshCell& cell() const { return mesh_.cells[range_.first]; }
    CellPlace place() const { return place_of(cell()); }
    CellTriangles triangles() const { return range_; }

    void next() {
        range_.first = range_.end;
        find_end();
    }

    /// The cell's triangles by keys, lowest key first, sorted.
    void list(std::vector<std::array<std::uint64_t, 3>>& out) const {
        out.clear();
        for (std::size_t t = range_.first; t < range_.end; ++t) {
            const auto& [a, b, c] = mesh_.triangles[t];
            auto& keys = out.emplace_back(std::array{mesh_.keys[a], mesh_.keys[b], mesh_.keys[c]});
            std::rotate(keys.begin(), std::min_element(keys.begin(), keys.end()), keys.end());
        }
        std::sort(out.begin(), out.end());
    }

  private:
    void find_end() {
        range_.end = range_.first;
        while (range_.end < mesh_.triangles.size() &&
               place_of(mesh_.cells[range_.end]) == place_of(mesh_.cells[range_.first])) {
            ++range_.end;
        }
    }

    const WeldedMesh& mesh_;
    CellTriangles range_;
};

void check_cells(const WeldedMesh& mesh) {
    if (mesh.cells.size() != mesh.triangles.size()) {
        throw RequestError(ExitCode::failed,
                           fmt::format("comparing meshes: {} triangles tell {} cells",
                                       mesh.triangles.size(), mesh.cells.size()));
    }
    const auto less = [](const MeshCell& a, const MeshCell& b) {
        return place_of(a) < place_of(b);
    };
    const auto bad = std::is_sorted_until(mesh.cells.begin(), mesh.cells.end(), less);
    if (bad != mesh.cells.end()) {
        throw RequestError(
            ExitCode::failed,
            fmt::format("comparing meshes: cell {} {} {} comes too late", bad->i, bad->j, bad->k));
    }
}

void show(CellTriangles triangles, Shown& shown) {
    std::fill(shown.begin() + static_cast<std::ptrdiff_t>(triangles.first),
              shown.begin() + static_cast<std::ptrdiff_t>(triangles.end), std::uint8_t{1});
}

std::vector<CaseDifference> sorted_cases(const std::array<std::size_t, 256>& counts) {
    std::vector<CaseDifference> cases;
    for (std::size_t inside = 0; inside < counts.size(); ++inside) {
        if (counts[inside] != 0) {
            cases.push_back({static_cast<std::uint8_t>(inside), counts[inside]});
        }
    }
    std::stable_sort(cases.begin(), cases.end(),
                     [](const auto& a, const auto& b) { return a.cells > b.cells; });
    return cases;
}

}  // namespace

MeshComparison compare_meshes(const WeldedMesh& a, const WeldedMesh& b, const VolumeGrid& grid,
                              const Pause& pause) {
    check_cells(a);
    check_cells(b);
    MeshComparison out;
    out.shown_a.assign(a.triangles.size(), 0);
    out.shown_b.assign(b.triangles.size(), 0);
    std::array<std::size_t, 256> counts{};
    std::vector<std::array<std::uint64_t, 3>> list_a, list_b;
    CellWalk in_a(a), in_b(b);
    while (!in_a.done() || !in_b.done()) {
        const bool has_a = !in_a.done() && (in_b.done() || in_a.place() <= in_b.place());
        const bool has_b = !in_b.done() && (in_a.done() || in_b.place() <= in_a.place());
        bool same = has_a && has_b;
        if (same) {
            in_a.list(list_a);
            in_b.list(list_b);
            same = list_a == list_b;
        }
        pause_at(out.cells, pause);
        ++out.cells;
        if (!same) {
            ++out.cells_differing;
            ++counts[(has_a ? in_a : in_b).cell().inside];
            if (has_a) show(in_a.triangles(), out.shown_a);
            if (has_b) show(in_b.triangles(), out.shown_b);
        }
        if (has_a) in_a.next();
        if (has_b) in_b.next();
    }
    out.cases = sorted_cases(counts);
    out.holes_a = certify(a, grid, pause).holes;
    out.holes_b = certify(b, grid, pause).holes;
    return out;
}

Reply comparison_reply(const MeshComparison& c, std::string_view name_a, std::string_view name_b) {
    constexpr std::size_t max_cases_in_text = 12;
    Reply reply;
    reply.text = fmt::format("{} and {} differ in {} of {} cells", name_a, name_b,
                             c.cells_differing, c.cells);
    std::vector<Fields> cases;
    for (const CaseDifference& difference : c.cases) {
        const std::size_t listed = cases.size();
        if (listed <= max_cases_in_text) {
            reply.text += listed == max_cases_in_text
                              ? ", ..."
                              : fmt::format("{} {} ({})", listed == 0 ? "; cases" : ",",
                                            difference.inside, difference.cells);
        }
        cases.push_back({{"case", std::int64_t{difference.inside}},
                         {"cells", static_cast<std::int64_t>(difference.cells)}});
    }
    reply.text +=
        fmt::format("\n  holes: {} has {}, {} has {}", name_a, c.holes_a, name_b, c.holes_b);
    reply.fields = {
        {"cells", static_cast<std::int64_t>(c.cells)},
        {"cells_differing", static_cast<std::int64_t>(c.cells_differing)},
        {"cases", std::move(cases)},
        {"holes", Fields{{std::string(name_a), c.holes_a}, {std::string(name_b), c.holes_b}}}};
    return reply;
}

}  // namespace pxpl5::host
