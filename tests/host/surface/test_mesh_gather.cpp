// Slabs put together into one mesh.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/error.hpp"
#include "tests/host/surface/surface_support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using host::MeshGather;
using host::RequestError;
using host::WeldedMesh;

namespace {

Volume noise(unsigned seed) {
    std::mt19937 random(seed);
    return random_volume({9, 7, 8}, Scalar::int16, 10, random);
}

/// The error of gather() for these slabs of one GP.
std::string error_of(const Slabs& slabs, const host::VolumeGrid& grid) {
    try {
        gather(messages_of(slabs), grid);
    } catch (const RequestError& error) {
        return error.what();
    }
    return "";
}

bool has(const std::string& text, const std::string& words) {
    INFO(text);
    const bool found = text.find(words) != std::string::npos;
    CHECK(found);
    return found;
}

void check_same(const WeldedMesh& a, const WeldedMesh& b) {
    CHECK(a.keys == b.keys);
    CHECK(a.p_grid == b.p_grid);
    CHECK(a.normals == b.normals);
    CHECK(a.triangles == b.triangles);
    REQUIRE(a.slabs.size() == b.slabs.size());
    for (std::size_t s = 0; s < a.slabs.size(); ++s) {
        CHECK(a.slabs[s].slab == b.slabs[s].slab);
        CHECK(a.slabs[s].first == b.slabs[s].first);
        CHECK(a.slabs[s].count == b.slabs[s].count);
    }
}

/// A vertex of slab `slab` that the slab above shares.
std::size_t shared_vertex(const Slabs& slabs, std::size_t slab, const host::VolumeGrid& grid) {
    const auto& keys = slabs[slab].keys;
    const std::uint64_t first = 4 * grid.slice_voxels() * (slab + 1);
    const auto found =
        std::find_if(keys.begin(), keys.end(), [&](auto key) { return key >= first; });
    REQUIRE(found != keys.end());
    return static_cast<std::size_t>(found - keys.begin());
}

}  // namespace

TEST_SUITE("host/surface/mesh_gather") {
    TEST_CASE("putting many slabs together can be ended between slices") {
        const Volume volume = make_volume({3, 3, 40}, Scalar::int16, [](int x, int y, int) {
            return x == 1 && y == 1 ? 1.0 : 0.0;
        });
        const auto messages = messages_of(extract_slabs(volume, 0.5));
        const host::VolumeGrid grid = grid_of(volume.shape);
        int pauses = 0;
        check_same(gather(messages, grid, [&] { ++pauses; }), gather(messages, grid));
        CHECK(pauses == 2);
        const auto end = [] { throw RequestError(host::ExitCode::failed, "ended"); };
        CHECK_THROWS_AS(gather(messages, grid, end), RequestError);
    }
    TEST_CASE("vertices ascend by key, each once, and triangles keep their corners and order") {
        const unsigned seed = seed_or(5U);
        CAPTURE(seed);
        const Volume volume = noise(seed);
        for (const auto rule : {CaseRule::watertight, CaseRule::asymptotic}) {
            const Slabs slabs = extract_slabs(volume, 5, rule);
            const WeldedMesh mesh = gather(messages_of(slabs), grid_of(volume.shape));
            REQUIRE(mesh.triangles.size() > 500);
            CHECK(std::is_sorted(mesh.keys.begin(), mesh.keys.end(), std::less_equal<>{}));
            // An independent weld: a map from keys to positions.
            std::map<std::uint64_t, glm::vec3> known;
            for (const gp::SlabMesh& slab : slabs)
                for (std::size_t i = 0; i < slab.keys.size(); ++i)
                    known[slab.keys[i]] = slab.vertices[i].p_voxel;
            CHECK(mesh.keys.size() == known.size());
            bool centers = false;
            for (std::size_t i = 0; i < mesh.keys.size(); ++i) {
                CHECK(mesh.p_grid[i] == known.at(mesh.keys[i]));
                centers = centers || mesh.keys[i] % 4 == 3;
            }
            CHECK(centers == (rule == CaseRule::asymptotic));
            std::size_t triangle = 0;
            for (const gp::SlabMesh& slab : slabs) {
                const host::SlabTriangles& part = mesh.slabs[static_cast<std::size_t>(slab.slab)];
                CHECK(part.slab == static_cast<std::uint32_t>(slab.slab));
                CHECK(part.first == triangle);
                CHECK(part.count == slab.indices.size() / 3);
                for (std::size_t i = 0; i < slab.indices.size(); i += 3, ++triangle) {
                    for (std::size_t c = 0; c < 3; ++c)
                        CHECK(mesh.keys[mesh.triangles[triangle][c]] ==
                              slab.keys[slab.indices[i + c]]);
                    const gp::Origin& origin = slab.origins[i / 3];
                    const host::MeshCell& cell = mesh.cells[triangle];
                    CHECK(cell.i == origin.i);
                    CHECK(cell.j == origin.j);
                    CHECK(cell.k == slab.slab);
                    CHECK(cell.inside == origin.inside);
                    CHECK(cell.joined == origin.joined);
                }
            }
            CHECK(triangle == mesh.triangles.size());
        }
    }

    TEST_CASE("the mesh is the same for any number of GPs and order of arrival") {
        const unsigned seed = seed_or(6U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        const Volume volume = noise(seed);
        const Slabs slabs = extract_slabs(volume, 4);
        const WeldedMesh one = gather(messages_of(slabs), grid_of(volume.shape));
        for (const std::size_t gp_count : {2U, 3U, 7U, 12U}) {
            auto messages = messages_of(slabs, gp_count);
            std::shuffle(messages.begin(), messages.end(), random);
            check_same(one, gather(messages, grid_of(volume.shape)));
        }
    }

    TEST_CASE("a surface without triangles is an empty mesh") {
        const Volume volume = noise(1);
        const WeldedMesh mesh = mesh_of(volume, 1000);
        CHECK(mesh.keys.empty());
        CHECK(mesh.triangles.empty());
        CHECK(mesh.slabs.size() == 7);
    }

    TEST_CASE("slabs that do not agree on a vertex are named with its key") {
        const Volume volume = noise(2);
        const host::VolumeGrid grid = grid_of(volume.shape);
        const Slabs good = extract_slabs(volume, 5);
        REQUIRE(error_of(good, grid).empty());
        const std::size_t at = shared_vertex(good, 2, grid);
        const std::string named = "slab 2, vertex key " + std::to_string(good[2].keys[at]);
        Slabs bad = good;
        float& y = bad[2].vertices[at].p_voxel.y;
        y = std::nextafter(y, 99.0F);
        CHECK(has(error_of(bad, grid), named));
        bad = good;
        ++bad[2].vertices[at].normal[1];
        CHECK(has(error_of(bad, grid), named));
        bad = good;
        bad[2].keys[at] = good[2].keys[at] + 2;  // Along z, out of the slab.
        CHECK(has(error_of(bad, grid), "is not on an edge of the slab"));
    }

    TEST_CASE("a shared vertex that one slab lacks, and a key twice, are named") {
        // One voxel inside: slabs 1 and 2 share the four edges around it in slice 2.
        const Volume volume = make_volume({5, 5, 5}, Scalar::int16, [](int x, int y, int z) {
            return x == 2 && y == 2 && z == 2 ? 4.0 : 0.0;
        });
        const host::VolumeGrid grid = grid_of(volume.shape);
        const Slabs good = extract_slabs(volume, 1);
        Slabs bad = good;
        bad[1] = {};
        bad[1].slab = 1;
        CHECK(has(error_of(bad, grid), "is not in slab 1, which shares it"));
        bad = good;
        bad[2] = {};
        bad[2].slab = 2;
        CHECK(has(error_of(bad, grid), "is not in slab 2, which shares it"));
        bad = good;
        bad[2].keys[1] = bad[2].keys[0];
        CHECK(has(error_of(bad, grid), "slab 2, vertex key " + std::to_string(bad[2].keys[0])));
        CHECK(has(error_of(bad, grid), "is there twice"));
        bad = good;
        bad[1].keys[0] = 4 * (25 + 4);  // An edge that leaves the volume at x = 4.
        CHECK(has(error_of(bad, grid), "(voxel 4 0 1, x): is not on an edge of the slab"));
        bad[1].keys[0] = 4 * (25 + 20) + 1;
        CHECK(has(error_of(bad, grid), "(voxel 0 4 1, y): is not on an edge of the slab"));
        bad[1].keys[0] = 4 * 125;
        CHECK(has(error_of(bad, grid), "is not on an edge of the slab"));
    }

    TEST_CASE("slabs that are missing, come twice, or are not the volume's are refused") {
        const Volume volume = noise(3);
        const Slabs slabs = extract_slabs(volume, 5);
        const auto messages = messages_of(slabs, 3);
        const auto refusal = [&](const host::VolumeGrid& grid, std::uint16_t surface,
                                 std::uint32_t revision, std::vector<std::size_t> order) {
            MeshGather gather(grid, surface, revision);
            try {
                for (const std::size_t i : order) gather.add(messages[i]);
                gather.finish();
            } catch (const RequestError& error) {
                return std::string(error.what());
            }
            return std::string();
        };
        const host::VolumeGrid grid = grid_of(volume.shape);
        host::VolumeGrid lower = grid;
        lower.nz = 4;
        CHECK(refusal(grid, test_surface, test_revision, {2, 0, 1}).empty());
        CHECK(has(refusal(grid, test_surface, test_revision, {0, 2}),
                  "mesh of slab 1 is missing, of 7 slabs 2"));
        CHECK(has(refusal(grid, test_surface, test_revision, {0, 1, 2, 1}),
                  "mesh of slab 1 came twice, from node 2"));
        CHECK(has(refusal(lower, test_surface, test_revision, {0}),
                  "mesh of slab 3 from node 1; the volume has 3 slabs"));
        CHECK(has(refusal(grid, 4, test_revision, {0}),
                  "mesh of surface 3 revision 7 from node 1, expected 4 revision 7"));
        CHECK(has(refusal(grid, test_surface, 8, {0}), "expected 3 revision 8"));
        MeshGather gather(grid, test_surface, test_revision);
        CHECK(gather.missing() == 7);
        gather.add(messages[1]);
        CHECK(gather.missing() == 5);
    }

    TEST_CASE("slabs that tell their triangles' cells and slabs that do not are refused") {
        const Volume volume = noise(4);
        Slabs slabs = extract_slabs(volume, 5);
        slabs[3].origins.clear();
        CHECK(has(error_of(slabs, grid_of(volume.shape)), "mesh of slab 3 from node 1 lacks"));
        for (gp::SlabMesh& slab : slabs) slab.origins.clear();
        const auto mesh = gather(messages_of(slabs), grid_of(volume.shape));
        CHECK(mesh.cells.empty());
        CHECK_FALSE(mesh.triangles.empty());
    }
}
