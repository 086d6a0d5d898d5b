// Surfaces on their way into files: closed at the volume's border, cut, joined by place.
#include <doctest/doctest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <random>

#include "host/surface/components.hpp"
#include "host/surface/export/border_cap.hpp"
#include "host/surface/export/plane_cut.hpp"
#include "host/surface/mesh_distance.hpp"
#include "host/surface/patient_mesh.hpp"
#include "tests/host/surface/surface_support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using host::Certificate;
using host::WeldedMesh;
using test::for_host;
using test::grid_of;
using test::mesh_of;
using test::Volume;

namespace {

/// The mesh that the program writes: apart, closed, in millimeters.
WeldedMesh closed_mesh(const Volume& volume, double isovalue) {
    WeldedMesh mesh = mesh_of(volume, isovalue);
    host::keep_apart(mesh, grid_of(volume.shape));
    host::cap_at_border(mesh, for_host(volume), isovalue);
    host::move_to_patient(mesh, grid_of(volume.shape));
    return mesh;
}

/// The certificate of a file with the mesh's triangles.
Certificate in_file(const WeldedMesh& mesh) {
    const host::WeldedFile file = host::weld(mesh.p_grid, mesh.triangles);
    CHECK(file.collapsed == 0);
    return host::certify(file.mesh, host::patient_grid());
}

void check_closed(const Certificate& certificate) {
    CHECK(certificate.closed());
    CHECK(certificate.manifold());
    CHECK(certificate.oriented());
}

/// The area that closes an open mesh, by the sum of its triangles' areas along `normal`.
double open_area(const WeldedMesh& mesh, const glm::dvec3& normal) {
    glm::dvec3 sum(0);
    for (const auto& [a, b, c] : mesh.triangles) {
        const glm::dvec3 p(mesh.p_grid[a]);
        sum += glm::cross(glm::dvec3(mesh.p_grid[b]) - p, glm::dvec3(mesh.p_grid[c]) - p) / 2.0;
    }
    return std::abs(glm::dot(sum, normal));
}

/// Smooth noise: surfaces with tunnels and cavities that leave the volume on all sides.
Volume noise(std::mt19937_64& random, const glm::dmat3& steps) {
    std::uniform_real_distribution<double> phase(0, 6.28);
    std::array<glm::dvec3, 6> waves{};
    std::array<double, 6> phases{};
    for (std::size_t i = 0; i < waves.size(); ++i) {
        waves[i] = glm::dvec3(phase(random), phase(random), phase(random)) / 6.0 - 0.5;
        phases[i] = phase(random);
    }
    return test::placed_volume({14, 11, 9}, steps, [&](const glm::dvec3& p) {
        double sum = 0;
        for (std::size_t i = 0; i < waves.size(); ++i) {
            sum += std::sin(glm::dot(waves[i], p) + phases[i]);
        }
        return sum;
    });
}

}  // namespace

TEST_SUITE("host/surface/file_mesh") {
    TEST_CASE("a capped surface is closed and has the volume that the faces enclose") {
        std::mt19937_64 random(test::seed_or(4711U));
        for (int round = 0; round < 40; ++round) {
            CAPTURE(round);
            // Whole numbers, so that many voxels have the isovalue.
            Volume volume = test::random_volume({6, 5, 4}, Scalar::int16, 5, random);
            if (round % 2 == 1) {
                volume.shape.voxel_to_patient[0] *= -0.7;  // Mirrored.
            }
            const double isovalue = round % 4 < 2 ? 2 : 2.5;
            WeldedMesh apart = mesh_of(volume, isovalue);
            host::keep_apart(apart, grid_of(volume.shape));
            const Certificate faces = host::certify(apart, grid_of(volume.shape));
            const Certificate file = in_file(closed_mesh(volume, isovalue));
            check_closed(file);
            CHECK(file.volume_mm3 == doctest::Approx(faces.volume_mm3).epsilon(1e-5));
            CHECK(file.area_mm2 > faces.area_mm2);
        }
    }

    TEST_CASE(
        "a surface that does not reach the border, or without one component, stays as it is") {
        const Volume voxel = test::one_voxel(10);
        CHECK(closed_mesh(voxel, 5).triangles.size() == mesh_of(voxel, 5).triangles.size());
        // Two bars through the volume; one is left out, so nothing covers its ends.
        const Volume bars = test::make_volume({9, 5, 6}, Scalar::int16, [](int x, int y, int) {
            return y == 2 && (x == 2 || x == 6) ? 10.0 : 0.0;
        });
        const WeldedMesh both = mesh_of(bars, 5);
        const auto parts = host::find_components(both, grid_of(bars.shape));
        REQUIRE(parts.components.size() == 2);
        WeldedMesh one = host::shown_part(both, host::show_component(parts, 0));
        host::cap_at_border(one, for_host(bars), 5);
        host::move_to_patient(one, grid_of(bars.shape));
        const Certificate file = in_file(one);
        check_closed(file);
        CHECK(file.components == 1);
        // A square of diagonal 1 from voxel 0 to voxel 5.
        CHECK(file.volume_mm3 == doctest::Approx(0.5 * 5));
    }

    TEST_CASE("both sides of a cut are closed, and together they have the whole volume") {
        std::mt19937_64 random(test::seed_or(815U));
        std::uniform_real_distribution<double> any(-1, 1);
        for (int round = 0; round < 40; ++round) {
            CAPTURE(round);
            const glm::dmat3 steps(1.3, 0.2, 0, -0.2, 0.9, 0, 0, 0.3, round % 2 == 0 ? 2 : -2);
            const WeldedMesh whole = closed_mesh(noise(random, steps), 0.4);
            // Every fourth plane goes through voxels along their axes.
            const glm::dvec3 normal =
                round % 4 == 0 ? glm::normalize(glm::cross(steps[0], steps[1]))
                               : glm::normalize(glm::dvec3(any(random), any(random), any(random)));
            const glm::dvec4 plane(normal, round % 4 == 0 ? 0 : 2 * any(random));
            WeldedMesh kept = whole, rest = whole;
            host::cut_by_plane(kept, plane, 0.002, true);
            host::cut_by_plane(rest, -plane, 0.002, true);
            const Certificate a = in_file(kept), b = in_file(rest), all = in_file(whole);
            check_closed(a);
            check_closed(b);
            CHECK(a.volume_mm3 > 0);
            CHECK(a.volume_mm3 + b.volume_mm3 == doctest::Approx(all.volume_mm3).epsilon(0.002));
            // Each side has the cut once more, and no triangle twice.
            const double cut_mm2 = a.area_mm2 + b.area_mm2 - all.area_mm2;
            CHECK(cut_mm2 > 0);
            WeldedMesh open = whole;
            host::cut_by_plane(open, plane, 0.002, false);
            const Certificate uncapped = in_file(open);
            CHECK(!uncapped.closed());
            CHECK(2 * (a.area_mm2 - uncapped.area_mm2) == doctest::Approx(cut_mm2).epsilon(0.01));
        }
    }

    TEST_CASE("a cut whose loops have many corners at one height is closed without overlaps") {
        std::mt19937_64 random(test::seed_or(1816U));
        for (int round = 0; round < 30; ++round) {
            CAPTURE(round);
            // Few values and a plane along the grid: most corners lie on few lines.
            const Volume volume = test::random_volume({20, 19, 18}, Scalar::int16, 4, random);
            const WeldedMesh whole = closed_mesh(volume, 0.5);
            const int axis = round % 3;
            glm::dvec4 plane(0, 0, 0, -8.5 - round % 2 * 0.25);
            plane[axis] = 1;
            for (const glm::dvec4& side : {plane, -plane}) {
                WeldedMesh capped = whole, open = whole;
                host::cut_by_plane(capped, side, 0.002, true);
                host::cut_by_plane(open, side, 0.002, false);
                const Certificate file = in_file(capped);
                check_closed(file);
                const double cover_mm2 = file.area_mm2 - in_file(open).area_mm2;
                CHECK(cover_mm2 ==
                      doctest::Approx(open_area(open, glm::dvec3(plane))).epsilon(1e-4));
            }
        }
    }

    TEST_CASE("half a ball has half its volume and the disk of its cut") {
        const Volume ball = test::placed_volume({41, 41, 41}, glm::dmat3(0.5),
                                                [](const auto& p) { return 8 - glm::length(p); });
        WeldedMesh half = closed_mesh(ball, 0);
        const Certificate whole = in_file(half);
        host::cut_by_plane(half, {0, 0.6, 0.8, 0}, 0.001, true);
        const Certificate file = in_file(half);
        check_closed(file);
        const double pi = std::numbers::pi;
        CHECK(file.volume_mm3 == doctest::Approx(2.0 / 3 * pi * 512).epsilon(0.01));
        CHECK(file.area_mm2 - whole.area_mm2 / 2 == doctest::Approx(pi * 64).epsilon(0.01));
    }

    TEST_CASE("loops with holes and islands become triangles of their area") {
        std::vector<glm::dvec2> points;
        std::vector<std::vector<std::uint32_t>> loops;
        const auto add_square = [&](glm::dvec2 low, double side, bool is_hole) {
            const auto first = static_cast<std::uint32_t>(points.size());
            for (const glm::dvec2 corner :
                 {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(1, 1), glm::dvec2(0, 1)}) {
                points.push_back(low + side * corner);
            }
            loops.push_back({first, first + 1, first + 2, first + 3});
            if (is_hole) std::swap(loops.back()[1], loops.back()[3]);
        };
        add_square({0, 0}, 10, false);
        add_square({1, 1}, 3, true);
        add_square({6, 1}, 3, true);
        add_square({1, 6}, 3, true);
        add_square({2, 2}, 1, false);  // An island in the first hole.
        const auto triangles = host::triangulate_loops(points, loops).triangles;
        double area = 0;
        for (const auto& [a, b, c] : triangles) {
            const glm::dvec2 p = points[b] - points[a], q = points[c] - points[a];
            const double doubled = p.x * q.y - p.y * q.x;
            CHECK(doubled >= 0);
            area += doubled / 2;
        }
        CHECK(area == doctest::Approx(100 - 27 + 1));
        // n corners and h holes: n + 2 h - 2 triangles; the island has 2.
        CHECK(triangles.size() == 16 + 6 - 2 + 2);
    }

    TEST_CASE("loops that cross give edges of at most two triangles") {
        std::mt19937_64 random(test::seed_or(1817U));
        std::uniform_int_distribution<int> any(0, 6);
        for (int round = 0; round < 300; ++round) {
            CAPTURE(round);
            std::vector<glm::dvec2> points;
            std::vector<std::vector<std::uint32_t>> loops(2);
            for (std::uint32_t corner = 0; corner < 16; ++corner) {
                points.emplace_back(any(random), any(random));
                loops[corner / 8].push_back(corner);
            }
            std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
            for (const auto& loop : loops) {
                for (std::size_t i = 0; i < loop.size(); ++i) {
                    ++uses[std::minmax(loop[i], loop[(i + 1) % loop.size()])];
                }
            }
            for (const auto& t : host::triangulate_loops(points, loops).triangles) {
                for (std::size_t i = 0; i < 3; ++i) ++uses[std::minmax(t[i], t[(i + 1) % 3])];
            }
            for (const auto& [edge, count] : uses) CHECK(count == 2);
        }
    }

    TEST_CASE("vertices at one place become one, and the triangles that collapse are counted") {
        const std::vector<glm::vec3> points = {{0, 0, 0}, {1, 0, 0},    {0, 1, 0},
                                               {1, 1, 0}, {-0.F, 0, 0}, {5, 5, 5}};
        const std::vector<std::array<std::uint32_t, 3>> triangles = {
            {0, 1, 2}, {1, 3, 2}, {0, 1, 4}};
        const host::WeldedFile file = host::weld(points, triangles);
        CHECK(file.mesh.p_grid.size() == 4);
        CHECK(file.mesh.triangles.size() == 2);
        CHECK(file.collapsed == 1);
        const Certificate certificate = host::certify(file.mesh, host::patient_grid());
        CHECK(!certificate.closed());
        CHECK(certificate.holes == 1);
        CHECK(certificate.border_edges == 0);
        CHECK(certificate.area_mm2 == doctest::Approx(1));
    }

    TEST_CASE("only triangles that enclose a volume have one, wherever they lie") {
        const WeldedMesh ball =
            closed_mesh(test::placed_volume({17, 17, 17}, glm::dmat3(1.0),
                                            [](const auto& p) { return 6 - glm::length(p); }),
                        0);
        const auto moved = [](WeldedMesh mesh, float mm) {
            for (glm::vec3& p : mesh.p_grid) p.x += mm;
            return in_file(mesh);
        };
        const auto json = [](const Certificate& certificate) {
            return host::json_text(host::certificate_reply(certificate, "s").fields);
        };
        const auto has = [](const std::string& text, const char* part) {
            return text.find(part) != std::string::npos;
        };
        WeldedMesh open = ball, inwards = ball;
        host::cut_by_plane(open, {1, 0, 0, -2}, 0.002, false);
        for (auto& triangle : inwards.triangles) std::swap(triangle[0], triangle[1]);
        for (const float mm : {0.F, 100.F}) {
            CAPTURE(mm);
            CHECK(has(json(moved(ball, mm)), "\"volume_ml\":0."));
            CHECK(has(json(moved(ball, mm)), "\"inside_out\":false"));
            CHECK(!has(json(moved(open, mm)), "volume_ml"));
            const Certificate found = moved(inwards, mm);
            CHECK(has(json(found), "\"volume_ml\":0."));
            CHECK(has(json(found), "\"inside_out\":true"));
            CHECK(has(host::certificate_reply(found, "s").text, "the faces point inwards"));
        }
        WeldedMesh torn = ball;
        std::swap(torn.triangles[7][0], torn.triangles[7][1]);
        CHECK(!has(json(in_file(torn)), "volume_ml"));
        const Certificate nothing = in_file({});
        CHECK(!nothing.closed());
        CHECK(!nothing.closed_but_for_border());
        CHECK(!has(json(nothing), "volume_ml"));
    }

    TEST_CASE("the farthest point's distance from a surface is the true one") {
        const std::vector<glm::vec3> square = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
        const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 3}};
        const std::vector<glm::vec3> points = {{5, 5, 1}, {13, 14, 0}, {2, 3, -4}};
        CHECK(host::farthest_distance(points, square, triangles) == doctest::Approx(5));
    }
}
