#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "host/io/mesh/mesh_flips.hpp"
#include "host/io/mesh/mesh_simplify.hpp"
#include "host/surface/certificate.hpp"
#include "host/surface/mesh_distance.hpp"
#include "host/surface/patient_mesh.hpp"
#include "tests/host/io/mesh_solids.hpp"
#include "tests/host/io/volume_files.hpp"

using namespace pxpl5::host::io;
using namespace pxpl5::test;

namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Edges that only one triangle has, in its direction.
std::set<Edge> open_edges(const std::vector<std::uint32_t>& indices) {
    std::set<Edge> edges;
    for (std::size_t first = 0; first < indices.size(); first += 3) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t a = indices[first + corner], b = indices[first + (corner + 1) % 3];
            CHECK(edges.insert({a, b}).second);  // Twice in one direction is not a surface.
        }
    }
    std::set<Edge> open;
    for (const Edge& edge : edges) {
        if (edges.count({edge.second, edge.first}) == 0) {
            open.insert(edge);
        }
    }
    return open;
}

/// The same triangles over vertices that are each at a place of its own.
std::vector<std::uint32_t> by_place(const std::vector<MeshPoint>& vertices,
                                    const std::vector<std::uint32_t>& indices) {
    std::map<std::array<float, 3>, std::uint32_t> number;
    std::vector<std::uint32_t> result;
    for (const std::uint32_t index : indices) {
        const glm::vec3 p = vertices[index].p_mm + 0.0F;
        const auto next = static_cast<std::uint32_t>(number.size());
        result.push_back(number.emplace(std::array{p.x, p.y, p.z}, next).first->second);
    }
    return result;
}

std::vector<glm::vec3> places(const std::vector<MeshPoint>& vertices) {
    std::vector<glm::vec3> places;
    for (const MeshPoint& vertex : vertices) {
        places.push_back(vertex.p_mm);
    }
    return places;
}

bool has(const std::vector<MeshPoint>& vertices, const glm::vec3& p) {
    return std::any_of(vertices.begin(), vertices.end(),
                       [&](const MeshPoint& vertex) { return vertex.p_mm == p; });
}

std::int64_t flat_triangles(const std::vector<MeshPoint>& vertices,
                            const std::vector<std::uint32_t>& indices) {
    std::int64_t count = 0;
    for (std::size_t first = 0; first < indices.size(); first += 3) {
        const glm::dvec3 a(vertices[indices[first]].p_mm), b(vertices[indices[first + 1]].p_mm),
            c(vertices[indices[first + 2]].p_mm);
        count += glm::cross(b - a, c - a) == glm::dvec3(0) ? 1 : 0;
    }
    return count;
}

/// A box of squares of 1 mm, as a cap over voxels is one.
Solid box(std::array<int, 3> size) {
    Solid solid{"box", {200, 200, 200}, {}, {}};
    std::map<std::array<int, 3>, std::uint32_t> number;
    const auto vertex = [&](const std::array<int, 3>& p) {
        const auto [at, is_new] =
            number.emplace(p, static_cast<std::uint32_t>(solid.vertices.size()));
        if (is_new) {
            solid.vertices.push_back({glm::vec3(p[0], p[1], p[2]), glm::vec3(0, 0, 1)});
        }
        return at->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (const bool high : {false, true}) {
            for (int i = 0; i < size[u]; ++i) {
                for (int j = 0; j < size[v]; ++j) {
                    const auto at = [&](int du, int dv) {
                        std::array<int, 3> p{};
                        p[axis] = high ? size[axis] : 0;
                        p[u] = i + du;
                        p[v] = j + dv;
                        return vertex(p);
                    };
                    std::array<std::uint32_t, 4> c = {at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
                    if (!high) {
                        std::swap(c[1], c[3]);
                    }
                    solid.indices.insert(solid.indices.end(), {c[0], c[1], c[2], c[0], c[2], c[3]});
                }
            }
        }
    }
    return solid;
}

}  // namespace

TEST_SUITE("host/io/mesh_simplify") {
    TEST_CASE("a sphere of a quarter of the triangles is closed, and nearly the same sphere") {
        const glm::vec3 center(3, -7, 100);
        const Solid solid = sphere(center, 50, 60, 90);
        const std::size_t before = solid.indices.size() / 3;
        const SimplifiedSurface got = simplify(solid.view(), 0.25);
        const std::size_t after = got.indices.size() / 3;
        CHECK(after <= before / 4);
        CHECK(after > before / 5);
        CHECK(open_edges(got.indices).empty());
        // Genus 0: V - E + F = 2, and 3 F = 2 E.
        CHECK(got.vertices.size() == 2 + after / 2);
        const double pi = 3.14159265358979323846;
        CHECK(signed_volume(places(got.vertices), got.indices) ==
              doctest::Approx(4.0 / 3.0 * pi * 125'000).epsilon(0.01));
        CHECK(got.moved_mm > 0);
        CHECK(got.moved_mm < 0.5);
        for (const MeshPoint& vertex : got.vertices) {
            CHECK(glm::distance(vertex.normal, (vertex.p_mm - center) / 50.0F) < 1e-5F);
        }
    }

    TEST_CASE("a bound of the error is kept, and decides how many triangles are left") {
        const Solid solid = sphere({3, -7, 100}, 50, 60, 90);
        std::size_t fewest = solid.indices.size();
        for (const double error_mm : {0.02, 0.1, 0.5, 2.0}) {
            CAPTURE(error_mm);
            const SimplifiedSurface got = simplify(solid.view(), 0, error_mm);
            CHECK(got.moved_mm <= error_mm);
            std::vector<std::array<std::uint32_t, 3>> triangles(got.indices.size() / 3);
            for (std::size_t i = 0; i < got.indices.size(); ++i) {
                triangles[i / 3][i % 3] = got.indices[i];
            }
            CHECK(pxpl5::host::farthest_distance(places(solid.vertices), places(got.vertices),
                                                 triangles) <= error_mm);
            CHECK(open_edges(got.indices).empty());
            CHECK(got.indices.size() < fewest);
            fewest = got.indices.size();
        }
        // Both together: at least the share stays.
        CHECK(simplify(solid.view(), 0.5, 2).indices.size() > fewest);
        CHECK(simplify(solid.view(), 0.5, 2).moved_mm <= 2);
        // Both sides of a thin plate may not join each other: then nothing would be left.
        const Solid plate = box({60, 60, 1});
        const SimplifiedSurface thin = simplify(plate.view(), 0, 2.5);
        CHECK(!thin.indices.empty());
        CHECK(thin.moved_mm <= 2.5);
        CHECK(open_edges(thin.indices).empty());
        // Less than floating-point numbers tell apart: all triangles stay.
        CHECK(simplify(solid.view(), 0, 1e-9).indices.size() == solid.indices.size());
    }

    TEST_CASE("no edge has more than two triangles, not even where many triangles met in a point") {
        const Solid solid = sphere({0, 0, 0}, 30, 120, 180);  // 180 of them at each pole.
        for (const double keep : {0.5, 0.1, 0.01}) {
            CHECK(open_edges(simplify(solid.view(), keep).indices).empty());
        }
    }

    TEST_CASE("a surface through voxels, where many vertices are at one place, keeps its shape") {
        Solid solid = sphere({0, 0, 0}, 30, 120, 180);
        for (MeshPoint& vertex : solid.vertices) {
            vertex.p_mm = glm::round(vertex.p_mm * 2.0F) / 2.0F;
        }
        const double volume = signed_volume(places(solid.vertices), solid.indices);
        for (const double keep : {0.5, 0.1, 0.02}) {
            CAPTURE(keep);
            const SimplifiedSurface got = simplify(solid.view(), keep);
            CHECK(static_cast<double>(got.indices.size()) <=
                  keep * static_cast<double>(solid.indices.size()) + 3);
            CHECK(open_edges(by_place(got.vertices, got.indices)).empty());
            CHECK(signed_volume(places(got.vertices), got.indices) ==
                  doctest::Approx(volume).epsilon(0.02));
            CHECK(got.moved_mm < 1.5);
        }
    }

    TEST_CASE("a rough surface stays a closed manifold, and no vertex is farther than is told") {
        // Spheres with spikes: collapses that meet again would leave edges of four triangles.
        for (unsigned seed = 1; seed <= 6; ++seed) {
            Solid solid = sphere({0, 0, 0}, 30, 90, 140);
            std::mt19937 random(seed);
            for (MeshPoint& vertex : solid.vertices) {
                vertex.p_mm *= 0.6F + 0.8F * static_cast<float>(random() % 1000) / 1000;
            }
            for (const double keep : {0.4, 0.15, 0.05}) {
                CAPTURE(seed);
                CAPTURE(keep);
                const SimplifiedSurface got = simplify(solid.view(), keep);
                std::vector<std::array<std::uint32_t, 3>> triangles(got.indices.size() / 3);
                for (std::size_t i = 0; i < got.indices.size(); ++i) {
                    triangles[i / 3][i % 3] = got.indices[i];
                }
                const pxpl5::host::WeldedFile file =
                    pxpl5::host::weld(places(got.vertices), triangles);
                const pxpl5::host::Certificate certificate =
                    pxpl5::host::certify(file.mesh, pxpl5::host::patient_grid());
                CHECK(certificate.closed());
                CHECK(certificate.manifold());
                CHECK(certificate.oriented());
                CHECK(certificate.triangles < static_cast<std::int64_t>(solid.indices.size() / 3));
                CHECK(pxpl5::host::farthest_distance(places(solid.vertices), places(got.vertices),
                                                     triangles) <= got.moved_mm);
            }
        }
    }

    TEST_CASE("no triangle of the result is without an area") {
        for (const double keep : {0.5, 0.2, 0.05, 0.01}) {
            CAPTURE(keep);
            const Solid solid = box({31, 17, 23});
            const SimplifiedSurface got = simplify(solid.view(), keep);
            CHECK(flat_triangles(got.vertices, got.indices) == 0);
            CHECK(open_edges(got.indices).empty());
            CHECK(static_cast<double>(got.indices.size()) <=
                  keep * static_cast<double>(solid.indices.size()) + 3 * 12);
            CHECK(signed_volume(places(got.vertices), got.indices) ==
                  doctest::Approx(31 * 17 * 23).epsilon(1e-6));
            CHECK(got.moved_mm < 1e-5);
        }
        Solid rounded = sphere({0, 0, 0}, 30, 120, 180);
        for (MeshPoint& vertex : rounded.vertices) {
            vertex.p_mm = glm::round(vertex.p_mm);
        }
        for (const double keep : {0.5, 0.2, 0.05}) {
            CAPTURE(keep);
            const SimplifiedSurface got = simplify(rounded.view(), keep);
            CHECK(flat_triangles(got.vertices, got.indices) == 0);
            CHECK(open_edges(got.indices).empty());
        }
    }

    TEST_CASE("a triangle without an area splits the triangle behind its longest side") {
        // A tetrahedron 0 1 2 3 with vertex 4 in the middle of the edge from 0 to 1, and a
        // triangle 0 4 1 that has no area.
        Solid solid = tetrahedron();
        solid.vertices.push_back(
            {(solid.vertices[0].p_mm + solid.vertices[1].p_mm) / 2.0F, glm::vec3(0, 0, 1)});
        // The faces at this edge are 0 2 1 and 0 1 3, of which the second is split.
        std::vector<std::uint32_t> indices = {0, 2, 1, 1, 4, 0, 0, 4, 3, 4, 1, 3, 0, 3, 2, 1, 2, 3};
        CHECK(open_edges(indices).empty());
        CHECK(flat_triangles(solid.vertices, indices) == 1);
        flip_flat_triangles(solid.vertices, indices);
        CHECK(flat_triangles(solid.vertices, indices) == 0);
        CHECK(indices.size() == 18);
        CHECK(open_edges(indices).empty());
        CHECK(signed_volume(places(solid.vertices), indices) == doctest::Approx(4));
    }

    TEST_CASE("a triangle without an area stays if nothing lies behind its longest side") {
        const std::vector<MeshPoint> vertices = {{{0, 0, 0}, {0, 0, 1}},
                                                 {{1, 0, 0}, {0, 0, 1}},
                                                 {{2, 0, 0}, {0, 0, 1}},
                                                 {{1, 1, 0}, {0, 0, 1}}};
        std::vector<std::uint32_t> indices = {0, 2, 1, 0, 1, 3, 1, 2, 3};
        const std::vector<std::uint32_t> before = indices;
        flip_flat_triangles(vertices, indices);
        CHECK(indices == before);
    }

    TEST_CASE("decimation stops before it is another surface") {
        // Of the sphere's 10,620 triangles, 4 would be a tetrahedron: 30 mm off.
        const SimplifiedSurface got =
            simplify(sphere({0, 0, 0}, 30, 60, 90).view(), 4.0 / 10'620.0);
        CHECK(got.indices.size() / 3 > 20);
        CHECK(got.moved_mm <= 0.05 * 60 + 1e-3);
    }

    TEST_CASE("edges at the surface's end stay") {
        const Solid whole = sphere({0, 0, 0}, 50, 40, 60);
        Solid half = whole;  // Triangles go from pole to pole: the first half ends at the equator.
        half.indices.resize(half.indices.size() / 2);
        const std::set<Edge> before = open_edges(half.indices);
        CHECK(before.size() == 60);
        const SimplifiedSurface got = simplify(half.view(), 0.2);
        CHECK(got.indices.size() < half.indices.size() / 3);
        CHECK(open_edges(got.indices).size() == before.size());
        for (const Edge& edge : before) {
            CHECK(has(got.vertices, half.vertices[edge.first].p_mm));
        }
    }

    TEST_CASE("a written mesh tells how many triangles there were and are, with their colors") {
        const TemporaryFolder folder;
        const Solid bone = tetrahedron(), skin = sphere({0, 0, 0}, 50, 60, 90);
        MeshExport mesh;
        mesh.surfaces = {bone.view(), skin.view()};
        mesh.keep = 0.5;
        const MeshWritten written = write_mesh(folder.file("m.ply"), mesh);
        const std::size_t before = (bone.indices.size() + skin.indices.size()) / 3;
        CHECK(written.triangles <= before / 2 + 4);
        CHECK(written.triangles > before * 2 / 5);
        CHECK(written.text.find("decimated from " + std::to_string(before) + " triangles") !=
              std::string::npos);
        CHECK(written.text.find(std::to_string(written.triangles) + " triangles") == 0);
        const std::string once = [&] {
            std::ifstream stream(folder.file("m.ply"), std::ios::binary);
            return std::string(std::istreambuf_iterator<char>(stream), {});
        }();
        CHECK(once.find("element face " + std::to_string(written.triangles) + "\n") !=
              std::string::npos);
        // The ball's color is the last vertex's. It ends the list before the faces.
        const std::size_t faces = 14 * written.triangles;
        const std::string color = once.substr(once.size() - faces - 3, 3);
        CHECK(color ==
              std::string({static_cast<char>(skin.color[0]), static_cast<char>(skin.color[1]),
                           static_cast<char>(skin.color[2])}));
        write_mesh(folder.file("again.ply"), mesh);
        std::ifstream stream(folder.file("again.ply"), std::ios::binary);
        CHECK(std::string(std::istreambuf_iterator<char>(stream), {}) == once);
    }

    TEST_CASE("all triangles stay if all are to be kept") {
        const Solid solid = sphere({0, 0, 0}, 10, 8, 8);
        const SimplifiedSurface got = simplify(solid.view(), 1);
        CHECK(got.indices == solid.indices);
        CHECK(got.vertices.size() == solid.vertices.size());
    }
}
