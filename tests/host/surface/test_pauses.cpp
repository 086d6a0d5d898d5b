// Pauses of long work on a mesh.
#include <doctest/doctest.h>

#include <glm/common.hpp>
#include <stdexcept>

#include "host/surface/certificate.hpp"
#include "host/surface/compare.hpp"
#include "host/surface/components.hpp"
#include "host/surface/export/mesh_smooth.hpp"
#include "host/surface/patient_mesh.hpp"

using namespace pxpl5::host;

namespace {

/// A sheet of 2 * side * side triangles with waves.
WeldedMesh sheet(std::uint32_t side) {
    WeldedMesh mesh;
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x) {
            mesh.keys.push_back(mesh.keys.size());
            mesh.p_grid.emplace_back(x, y, (x + y) % 2);
            mesh.normals.emplace_back(0, 0, 1);
        }
    }
    const std::uint32_t row = side + 1;
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t a = y * row; a < y * row + side; ++a) {
            mesh.triangles.push_back({a, a + 1, a + row + 1});
            mesh.triangles.push_back({a, a + row + 1, a + row});
        }
    }
    return mesh;
}

struct Ended : std::runtime_error {
    Ended() : std::runtime_error("ended in a pause") {}
};

/// Ends the work in pause 1, 2, 3, ... until it is done. Returns the number of pauses.
template <class Work>
int ends_in_each_pause(const Work& work) {
    for (int last = 1;; ++last) {
        int pauses = 0;
        try {
            work([&] {
                if (++pauses == last) {
                    throw Ended();
                }
            });
            CHECK(pauses == last - 1);
            return pauses;
        } catch (const Ended&) {
        }
    }
}

}  // namespace

TEST_SUITE("surface/pauses") {
    TEST_CASE("long work has pauses that can end it, and short work has none") {
        const WeldedMesh small = sheet(50), large = sheet(512);
        const auto certificate_pauses = [](const WeldedMesh& mesh) {
            return ends_in_each_pause(
                [&](const Pause& pause) { certify(mesh, patient_grid(), pause); });
        };
        const auto component_pauses = [](const WeldedMesh& mesh) {
            return ends_in_each_pause(
                [&](const Pause& pause) { find_components(mesh, patient_grid(), pause); });
        };
        CHECK(certificate_pauses(small) == 0);
        CHECK(component_pauses(small) == 0);
        // 2^19 triangles and a few more than 2^18 vertices, each some times.
        CHECK(certificate_pauses(large) > 8);
        CHECK(component_pauses(large) > 4);
    }
    TEST_CASE("a comparison of many cells can be ended") {
        WeldedMesh mesh = sheet(600);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto cell = static_cast<std::uint32_t>(t / 2);
            mesh.cells.push_back({static_cast<std::uint16_t>(cell % 600),
                                  static_cast<std::uint16_t>(cell / 600), 0, 1, 0});
        }
        const int certificates = 2 * ends_in_each_pause([&](const Pause& pause) {
                                     certify(mesh, patient_grid(), pause);
                                 });
        CHECK(ends_in_each_pause([&](const Pause& pause) {
                  compare_meshes(mesh, mesh, patient_grid(), pause);
              }) == certificates + 1);
    }
    TEST_CASE("smoothing that ends in a pause leaves the mesh as it was") {
        const WeldedMesh before = sheet(512);
        WeldedMesh mesh = before;
        const int pauses = ends_in_each_pause([&](const Pause& pause) {
            CHECK(mesh.p_grid == before.p_grid);
            CHECK(mesh.normals == before.normals);
            smooth_mesh(mesh, patient_grid(), 2, pause);
        });
        CHECK(pauses > 6);
        CHECK(mesh.p_grid != before.p_grid);
    }
}
