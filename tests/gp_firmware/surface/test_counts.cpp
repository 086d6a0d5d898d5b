// Tests the counts of extraction on volumes where they can be counted on paper.
#include <doctest/doctest.h>

#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::extract_all;
using pxpl5::test::Gp;
using pxpl5::test::make_volume;
using pxpl5::test::Volume;

namespace {

constexpr int nx = 70, ny = 11, nz = 4;
constexpr std::uint32_t cells = (nx - 1) * (ny - 1);
constexpr std::uint32_t x_edges = (nx - 1) * ny, y_edges = nx * (ny - 1);  // Of a slice.
constexpr std::uint32_t z_edges = nx * ny;

template <class Field>
std::vector<SlabMesh> meshes_of(Field field) {
    return extract_all(make_volume({nx, ny, nz}, Scalar::int16, field), 50);
}

void check(const SlabCounts& counts, std::uint32_t visited, std::uint32_t active,
           std::uint32_t edges_visited, std::uint32_t edges_crossed, std::uint32_t triangles) {
    CHECK(counts.cells_visited == visited);
    CHECK(counts.cells_active == active);
    CHECK(counts.edges_visited == edges_visited);
    CHECK(counts.edges_crossed == edges_crossed);
    CHECK(counts.triangles == triangles);
}

}  // namespace

TEST_SUITE("gp/counts") {
    TEST_CASE("in an empty volume nothing is looked at, nor in a full one") {
        for (const double value : {0.0, 100.0}) {
            for (const SlabMesh& mesh : meshes_of([=](int, int, int) { return value; })) {
                check(mesh.counts, 0, 0, 0, 0, 0);
                CHECK(mesh.counts.vertices == 0);
                CHECK(mesh.counts.rows_skipped == ny - 1);
            }
        }
    }

    TEST_CASE("of a plane between two slices every cell has two triangles, every z edge a vertex") {
        const auto meshes = meshes_of([](int, int, int z) { return z >= 2 ? 100.0 : 0.0; });
        check(meshes[0].counts, 0, 0, 0, 0, 0);
        check(meshes[1].counts, cells, cells, z_edges, z_edges, 2 * cells);
        check(meshes[2].counts, 0, 0, 0, 0, 0);
        CHECK(meshes[1].counts.vertices == z_edges);
    }

    TEST_CASE("of a plane across the rows every row is looked at whole, in every slab") {
        const auto meshes = meshes_of([](int x, int, int) { return x >= 30 ? 100.0 : 0.0; });
        for (const SlabMesh& mesh : meshes) {
            check(mesh.counts, cells, ny - 1, 2 * x_edges + 2 * y_edges + z_edges, 2 * ny,
                  2 * (ny - 1));
            // The upper slice's belong to the next slab, if there is one.
            CHECK(mesh.counts.vertices == (mesh.slab == nz - 2 ? 2 * ny : ny));
        }
    }

    TEST_CASE("of a plane between two rows only these rows are looked at") {
        const auto meshes = meshes_of([](int, int y, int) { return y >= 4 ? 100.0 : 0.0; });
        for (const SlabMesh& mesh : meshes) {
            check(mesh.counts, nx - 1, nx - 1, 2 * nx, 2 * nx, 2 * (nx - 1));
            CHECK(mesh.counts.rows_skipped == ny - 2);
        }
    }

    TEST_CASE("on a checkerboard every edge has a vertex, and every cell four triangles") {
        const auto meshes =
            meshes_of([](int x, int y, int z) { return (x + y + z) % 2 == 0 ? 100.0 : 0.0; });
        constexpr std::uint32_t all = 2 * x_edges + 2 * y_edges + z_edges;
        for (const SlabMesh& mesh : meshes) {
            check(mesh.counts, cells, cells, all, all, 4 * cells);
            CHECK(mesh.counts.vertices ==
                  (mesh.slab == nz - 2 ? all : x_edges + y_edges + z_edges));
        }
    }

    TEST_CASE("a GP's slices and runs are counted when all have come") {
        // Rows of even y are two runs, the others are of no two equal values side by side.
        const Volume volume = make_volume({nx, ny, 9}, Scalar::int16, [](int x, int y, int) {
            return y % 2 == 0 ? (x < 20 ? 1.0 : 2.0) : double(x % 7);
        });
        constexpr std::uint32_t even_rows = (ny + 1) / 2;
        const Gp whole(volume, {0, 1});
        CHECK(whole.store.counts().slices == 9);
        CHECK(whole.store.counts().rows_in_runs == 9 * even_rows);
        CHECK(whole.store.counts().runs == 9 * even_rows * 2);
        // Slabs 1 and 5: slices 0 .. 3 and 4 .. 7 come, 1, 2, 5 and 6 stay.
        const Gp second(volume, {1, 4});
        CHECK(second.store.counts().slices == 8);
        CHECK(second.store.counts().rows_in_runs == 4 * even_rows);
        CHECK(second.store.counts().runs == 4 * even_rows * 2);
    }
}
