// Defects: planted in meshes, and those of the 1987 table, each found and named with its cell.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/host/surface/surface_support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using host::Certificate;
using host::certify;
using host::Defect;
using host::DefectKind;
using host::WeldedMesh;

namespace {

const host::FieldValue& field(const host::Fields& fields, const std::string& name) {
    const auto found = std::find_if(fields.begin(), fields.end(),
                                    [&](const host::Field& f) { return f.name == name; });
    REQUIRE(found != fields.end());
    return found->value;
}

}  // namespace

TEST_SUITE("host/surface/defects") {
    TEST_CASE("the 1987 table leaves a hole between two cells, and both are named") {
        // The face at x = 1 has two inside corners across. Left of it all is outside, right of it
        // inside: 2 inside corners are kept apart, 6 are joined.
        const Volume volume = make_volume({3, 2, 2}, Scalar::int16, [](int x, int y, int z) {
            return x == 2 || (x == 1 && y == z) ? 1.0 : 0.0;
        });
        CHECK(certify_volume(volume, 1).good());
        const Certificate found = certify_volume(volume, 1, CaseRule::lorensen1987);
        CHECK_FALSE(found.closed_but_for_border());
        CHECK_FALSE(found.good());
        CHECK(found.holes == 1);
        CHECK(found.count(DefectKind::open_edge) == 4);
        // Corner c is at (c & 1, c >> 1 & 1, c >> 2).
        const std::uint8_t left = 1 << 1 | 1 << 7, right = 0b10101010 | 1 << 0 | 1 << 6;
        int in_left = 0, in_right = 0;
        for (const Defect& defect : found.defects) {
            if (defect.kind != DefectKind::open_edge) continue;
            REQUIRE(defect.cell);
            CHECK(defect.cell->j == 0);
            CHECK(defect.cell->k == 0);
            (defect.cell->i == 0 ? in_left : in_right) += 1;
            CHECK(defect.cell->inside == (defect.cell->i == 0 ? left : right));
            CHECK(defect.p_mm.x == 1);
        }
        CHECK(in_left == 2);
        CHECK(in_right == 2);
    }

    TEST_CASE("planted defects are found, counted and named") {
        const Volume volume = one_voxel(4);
        const host::VolumeGrid grid = grid_of(volume.shape);
        const WeldedMesh good = mesh_of(volume, 1);
        REQUIRE(certify(good, grid).closed());
        const auto kinds = [](const Certificate& found) {
            std::vector<std::int64_t> counts(found.defect_counts.begin(),
                                             found.defect_counts.end());
            return counts;
        };
        using Counts = std::vector<std::int64_t>;

        WeldedMesh bad = good;
        const host::MeshCell cell = bad.cells[0];
        bad.triangles.erase(bad.triangles.begin());
        bad.cells.erase(bad.cells.begin());
        Certificate found = certify(bad, grid);
        CHECK(kinds(found) == Counts{3, 0, 0, 0, 0, 0, 0});
        CHECK(found.holes == 1);
        CHECK_FALSE(found.closed_but_for_border());
        CHECK_FALSE(found.genus());
        // The neighbors across the three edges: they differ from the cell in one place each.
        for (const Defect& defect : found.defects) {
            REQUIRE(defect.cell);
            CHECK((defect.cell->i != cell.i) + (defect.cell->j != cell.j) +
                      (defect.cell->k != cell.k) ==
                  1);
        }

        bad = good;
        std::swap(bad.triangles[2][0], bad.triangles[2][1]);
        found = certify(bad, grid);
        CHECK(kinds(found) == Counts{0, 0, 3, 0, 0, 0, 0});
        CHECK_FALSE(found.oriented());
        CHECK(found.manifold());

        bad = good;
        bad.triangles.push_back(bad.triangles[5]);
        bad.cells.push_back(bad.cells[5]);
        found = certify(bad, grid);
        CHECK(kinds(found) == Counts{0, 3, 0, 0, 0, 1, 0});
        CHECK_FALSE(found.manifold());
        const auto repeated = std::find_if(
            found.defects.begin(), found.defects.end(),
            [](const Defect& defect) { return defect.kind == DefectKind::repeated_triangle; });
        REQUIRE(repeated != found.defects.end());
        CHECK(repeated->key_count == 3);
        CHECK(repeated->cell->i == bad.cells[5].i);
        CHECK(repeated->cell->j == bad.cells[5].j);
        CHECK(repeated->cell->k == bad.cells[5].k);

        bad = good;
        bad.triangles[1][2] = bad.triangles[1][0];
        found = certify(bad, grid);
        CHECK(found.count(DefectKind::collapsed_triangle) == 1);
        CHECK_FALSE(found.manifold());

        bad = good;
        bad.keys.push_back(bad.keys.back() + 4);
        bad.p_grid.emplace_back(1, 1, 1);
        bad.normals.emplace_back(0, 0, 1);
        found = certify(bad, grid);
        CHECK(kinds(found) == Counts{0, 0, 0, 0, 1, 0, 0});
        CHECK(found.defects[0].keys[0] == bad.keys.back());
        CHECK_FALSE(found.defects[0].cell);
    }

    TEST_CASE("two octahedra joined at a tip are pinched there, and two components") {
        const Volume volume = make_volume({5, 3, 3}, Scalar::int16, [](int x, int y, int z) {
            return x % 2 == 1 && y == 1 && z == 1 ? 4.0 : 0.0;
        });
        WeldedMesh mesh = mesh_of(volume, 1);
        // Voxel 21 is (1, 1, 1): the tips at x = 1.75 and 2.25 have the keys 4 * 21 and 4 * 22.
        const auto tip = [&](std::uint64_t key) {
            return static_cast<std::uint32_t>(std::find(mesh.keys.begin(), mesh.keys.end(), key) -
                                              mesh.keys.begin());
        };
        const std::uint32_t from = tip(4 * 22), to = tip(4 * 21);
        for (auto& triangle : mesh.triangles)
            std::replace(triangle.begin(), triangle.end(), from, to);
        const Certificate found = certify(mesh, grid_of(volume.shape));
        CHECK(found.count(DefectKind::pinched_vertex) == 1);
        CHECK(found.count(DefectKind::unused_vertex) == 1);
        CHECK(found.defects[0].keys[0] == 4 * 21);
        CHECK(found.components == 2);
        CHECK(found.closed());
        CHECK_FALSE(found.manifold());
    }

    TEST_CASE("defects are all counted and the first of each kind listed") {
        std::mt19937 random(44);
        const Volume volume = random_volume({20, 20, 20}, Scalar::uint8, 2, random);
        WeldedMesh mesh = mesh_of(volume, 1, CaseRule::lorensen1987);
        mesh.triangles.push_back(mesh.triangles[0]);
        mesh.cells.push_back(mesh.cells[0]);
        const Certificate found = certify(mesh, grid_of(volume.shape));
        CHECK(found.count(DefectKind::open_edge) > 1000);
        const auto listed = [&](DefectKind kind) {
            return std::count_if(found.defects.begin(), found.defects.end(),
                                 [&](const Defect& defect) { return defect.kind == kind; });
        };
        CHECK(listed(DefectKind::open_edge) == host::max_listed_defects);
        CHECK(listed(DefectKind::repeated_triangle) == 1);
    }

    TEST_CASE("the text says what a person must know, the fields what a program must") {
        const Volume volume = make_volume({3, 2, 2}, Scalar::int16, [](int x, int y, int z) {
            return x == 2 || (x == 1 && y == z) ? 1.0 : 0.0;
        });
        const auto text = [&](CaseRule rule) {
            return host::certificate_reply(certify_volume(volume, 1, rule), "bone").text;
        };
        const auto has = [](const std::string& whole, const std::string& part) {
            INFO(whole);
            CHECK(whole.find(part) != std::string::npos);
        };
        has(text(CaseRule::lorensen1987),
            "bone: not closed: 1 hole (4 open edges off the volume's border), not manifold, "
            "oriented");
        has(text(CaseRule::lorensen1987), "not defined: the surface has holes");
        has(text(CaseRule::lorensen1987), "cell 0 0 0 case 130");
        has(text(CaseRule::lorensen1987), "cell 1 0 0 case 235");
        has(text(CaseRule::watertight), "bone: closed but for the volume's border");
        has(text(CaseRule::watertight), "(closed by the faces of the scan)");
        has(host::certificate_reply(certify_volume(one_voxel(4), 1), "dot").text,
            "dot: closed, manifold, oriented\n  8 triangles, 6 vertices, 12 edges; Euler number 2; "
            "1 component; genus 0");
        has(host::certificate_reply(certify_volume(one_voxel(4), 5), "dot").text,
            "dot: no triangles");
        const auto fields =
            host::certificate_reply(certify_volume(volume, 1, CaseRule::lorensen1987), "bone")
                .fields;
        CHECK(std::get<std::int64_t>(field(fields, "holes")) == 1);
        CHECK_FALSE(std::get<bool>(field(fields, "closed_but_for_border")));
        const auto defects = std::get<std::vector<host::Fields>>(field(fields, "defects"));
        std::int64_t open = 0;
        std::int64_t right = 0;
        for (const host::Fields& defect : defects) {
            if (std::get<std::string>(field(defect, "kind")) != "open_edge") continue;
            ++open;
            const bool is_right = std::get<std::vector<double>>(field(defect, "cell"))[0] == 1;
            right += is_right ? 1 : 0;
            CHECK(std::get<std::int64_t>(field(defect, "case")) == (is_right ? 235 : 130));
        }
        CHECK(open == 4);
        CHECK(right == 2);
    }
}
