// The cells in which two case tables differ.
#include <doctest/doctest.h>

#include <algorithm>

#include "host/base/error.hpp"
#include "host/surface/compare.hpp"
#include "tests/host/surface/surface_support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using host::compare_meshes;
using host::MeshComparison;
using host::WeldedMesh;

namespace {

struct Pair {
    WeldedMesh watertight, lorensen1987;
    host::VolumeGrid grid;
    MeshComparison comparison;
};

Pair compare(const Volume& volume, double isovalue) {
    Pair out{mesh_of(volume, isovalue),
             mesh_of(volume, isovalue, CaseRule::lorensen1987),
             grid_of(volume.shape),
             {}};
    out.comparison = compare_meshes(out.watertight, out.lorensen1987, out.grid);
    return out;
}

/// Cases that the two tables treat otherwise: more than four inside corners, and a face whose
/// diagonals' corners differ.
bool differs(unsigned inside) {
    if (std::popcount(inside) <= 4) return false;
    const auto at = [inside](int c) { return (inside >> c & 1) != 0; };
    for (int face = 0; face < gp::cell_face_count; ++face) {
        const auto [a, b, c, d] = gp::face_corners(face);
        if (at(a) == at(c) && at(b) == at(d) && at(a) != at(b)) return true;
    }
    return false;
}

}  // namespace

TEST_SUITE("host/surface/compare") {
    TEST_CASE("one cell of two differs, and only its triangles are shown") {
        const Volume volume = make_volume({3, 2, 2}, Scalar::int16, [](int x, int y, int z) {
            return x == 2 || (x == 1 && y == z) ? 1.0 : 0.0;
        });
        const Pair pair = compare(volume, 1);
        const MeshComparison& c = pair.comparison;
        CHECK(c.cells == 2);
        CHECK(c.cells_differing == 1);
        REQUIRE(c.cases.size() == 1);
        CHECK(c.cases[0].inside == 235);
        CHECK(c.cases[0].cells == 1);
        CHECK(c.holes_a == 0);
        CHECK(c.holes_b == 1);
        for (std::size_t t = 0; t < c.shown_a.size(); ++t)
            CHECK(c.shown_a[t] == pair.watertight.cells[t].i);
        for (std::size_t t = 0; t < c.shown_b.size(); ++t)
            CHECK(c.shown_b[t] == pair.lorensen1987.cells[t].i);
        const auto reply = host::comparison_reply(c, "new", "old");
        CHECK(reply.text ==
              "new and old differ in 1 of 2 cells; cases 235 (1)\n  holes: new has 0, old has 1");
    }

    TEST_CASE("in noise just the cells differ whose case the tables treat otherwise") {
        const unsigned seed = seed_or(17U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        const Volume volume = random_volume({12, 11, 10}, Scalar::uint8, 4, random);
        const Pair pair = compare(volume, 2);
        const MeshComparison& c = pair.comparison;
        std::size_t cells = 0, differing = 0;
        for (int z = 0; z < 9; ++z)
            for (int y = 0; y < 10; ++y)
                for (int x = 0; x < 11; ++x) {
                    unsigned inside = 0;
                    for (int corner = 0; corner < 8; ++corner) {
                        const int at = ((z + (corner >> 2)) * 11 + y + (corner >> 1 & 1)) * 12 + x +
                                       (corner & 1);
                        const auto value = volume.values[static_cast<std::size_t>(at)];
                        inside |= (std::to_integer<int>(value) >= 2 ? 1U : 0U) << corner;
                    }
                    cells += inside != 0 && inside != 255 ? 1 : 0;
                    differing += differs(inside) ? 1 : 0;
                }
        CHECK(c.cells == cells);
        CHECK(c.cells_differing == differing);
        std::size_t in_cases = 0;
        for (const host::CaseDifference& difference : c.cases) {
            CHECK(differs(difference.inside));
            in_cases += difference.cells;
        }
        CHECK(in_cases == differing);
        CHECK(std::is_sorted(c.cases.begin(), c.cases.end(),
                             [](const auto& a, const auto& b) { return a.cells > b.cells; }));
        for (std::size_t t = 0; t < c.shown_a.size(); ++t)
            CHECK(c.shown_a[t] == (differs(pair.watertight.cells[t].inside) ? 1 : 0));
        for (std::size_t t = 0; t < c.shown_b.size(); ++t)
            CHECK(c.shown_b[t] == (differs(pair.lorensen1987.cells[t].inside) ? 1 : 0));
    }

    TEST_CASE("order of triangles and corners within a cell does not matter, direction does") {
        const WeldedMesh mesh = mesh_of(one_voxel(3), 1);
        const host::VolumeGrid grid = grid_of(one_voxel(3).shape);
        WeldedMesh other = mesh;
        for (auto& t : other.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
        CHECK(compare_meshes(mesh, other, grid).cells_differing == 0);
        std::swap(other.triangles[3][0], other.triangles[3][1]);
        CHECK(compare_meshes(mesh, other, grid).cells_differing == 1);
        // A cell that only one of them has.
        other = mesh;
        other.triangles.pop_back();
        other.cells.pop_back();
        const auto fewer = compare_meshes(mesh, other, grid);
        CHECK(fewer.cells == 8);
        CHECK(fewer.cells_differing == 1);
        CHECK(fewer.holes_b == 1);
        CHECK(compare_meshes(other, mesh, grid).cells_differing == 1);
    }

    TEST_CASE("meshes that do not tell their cells cannot be compared") {
        const WeldedMesh mesh = mesh_of(one_voxel(3), 1);
        const host::VolumeGrid grid = grid_of(one_voxel(3).shape);
        WeldedMesh other = mesh;
        other.cells.clear();
        CHECK_THROWS_WITH_AS(compare_meshes(mesh, other, grid),
                             "comparing meshes: 8 triangles tell 0 cells", host::RequestError);
        other = mesh;
        std::swap(other.cells[0], other.cells[7]);
        CHECK_THROWS_AS(compare_meshes(mesh, other, grid), host::RequestError);
    }
}
