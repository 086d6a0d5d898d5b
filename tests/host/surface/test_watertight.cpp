// Certificates of surfaces that have edges with more than two triangles.
#include <doctest/doctest.h>

#include <array>
#include <vector>

#include "host/surface/certificate.hpp"
#include "host/surface/patient_mesh.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// A surface in millimeters of six vertices, of which 0 and 1 lie on the z axis.
WeldedMesh mesh_of(Triangles triangles) {
    WeldedMesh mesh;
    mesh.p_grid = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}};
    mesh.keys = {0, 1, 2, 3, 4, 5};
    mesh.normals.assign(6, {0, 0, 1});
    mesh.triangles = std::move(triangles);
    return mesh;
}

/// A tetrahedron with outward faces, if its corners are positively oriented.
Triangles tetrahedron(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    return {{a, c, b}, {a, b, d}, {a, d, c}, {b, c, d}};
}

Triangles both() {
    Triangles triangles = tetrahedron(0, 2, 3, 1);
    for (const auto& t : tetrahedron(0, 4, 5, 1)) {
        triangles.push_back(t);
    }
    return triangles;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("surface/watertight") {
    TEST_CASE("two solids that share an edge are watertight and not manifold") {
        const Certificate c = certify(mesh_of(both()), patient_grid());
        CHECK(c.count(DefectKind::overfull_edge) == 1);
        CHECK(c.watertight());
        CHECK(c.closed());
        CHECK(c.oriented());
        CHECK_FALSE(c.manifold());
        CHECK(c.volume_mm3 == doctest::Approx(2.0 / 6));
        CHECK(has(certificate_reply(c, "s").text,
                  "watertight: each edge has as many triangles in one direction as in the other, "
                  "also the 1 with more than two"));
    }

    TEST_CASE("one solid alone is watertight, and its certificate need not say so") {
        const Certificate c = certify(mesh_of(tetrahedron(0, 2, 3, 1)), patient_grid());
        CHECK(c.watertight());
        CHECK_FALSE(has(certificate_reply(c, "s").text, "watertight"));
    }

    TEST_CASE("an edge that triangles use unequally often in both directions is not watertight") {
        Triangles triangles = both();
        triangles.erase(triangles.begin() + 1);  // Leaves three triangles at the shared edge.
        const Certificate three = certify(mesh_of(triangles), patient_grid());
        CHECK(three.count(DefectKind::overfull_edge) == 1);
        CHECK(three.count(DefectKind::open_edge) == 2);
        CHECK(three.unbalanced_edges == 3);
        CHECK_FALSE(three.watertight());
        CHECK(has(certificate_reply(three, "s").text, "not watertight: 3 edges"));

        Triangles turned = tetrahedron(0, 2, 3, 1);
        std::swap(turned[0][0], turned[0][1]);
        const Certificate two = certify(mesh_of(turned), patient_grid());
        CHECK(two.closed());
        CHECK(two.unbalanced_edges == 3);
        CHECK_FALSE(two.watertight());
    }

    TEST_CASE("edges that several triangles leave open in a face of the volume are its border") {
        // Two sheets end at the same edge in the face x = 0 of a volume of 8 x 8 x 8 voxels.
        WeldedMesh mesh;
        mesh.p_grid = {{0, 1, 1}, {0, 2, 1}, {1, 1, 2}, {1, 1, 0}};
        mesh.keys = {0, 1, 2, 3};
        mesh.normals.assign(4, {0, 0, 1});
        VolumeGrid grid;
        grid.nx = grid.ny = grid.nz = 8;
        // Keys place the vertices: 4 * voxel + axis, on edges along y in the face, else inside.
        const auto key = [](int x, int y, int z, int axis) {
            return static_cast<std::uint64_t>(4 * ((z * 8 + y) * 8 + x) + axis);
        };
        mesh.keys = {key(0, 1, 1, 1), key(0, 2, 1, 1), key(1, 1, 2, 1), key(1, 1, 3, 1)};
        mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
        const Certificate c = certify(mesh, grid);
        CHECK(c.border_edges == 1);
        CHECK(c.unbalanced_edges == 4);  // The other sides.
    }
}
