// Smoothing that keeps the volume.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <random>
#include <utility>

#include "host/surface/certificate.hpp"
#include "host/surface/export/mesh_smooth.hpp"
#include "host/surface/patient_mesh.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
using pxpl5::test::seed_or;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr int rings = 40, sides = 80;
constexpr double radius = 20;
constexpr glm::dvec3 center(25, 30, 35);

/// A sphere whose vertices lie up to `rough` off it, at random. open: without its upper half.
WeldedMesh rough_sphere(double rough, bool open = false) {
    std::minstd_rand random(seed_or<std::uint32_t>(7));
    std::uniform_real_distribution<double> off(-rough, rough);
    WeldedMesh mesh;
    const auto add = [&](double polar, double around) {
        const glm::dvec3 n(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                           std::cos(polar));
        mesh.keys.push_back(mesh.keys.size());
        mesh.p_grid.emplace_back(center + (radius + (rough > 0 ? off(random) : 0)) * n);
        mesh.normals.emplace_back(n);
    };
    add(0, 0);
    for (int ring = 1; ring < rings; ++ring) {
        for (int side = 0; side < sides; ++side) {
            add(pi * ring / rings, 2 * pi * side / sides);
        }
    }
    add(pi, 0);
    const auto at = [](int ring, int side) {
        return ring == 0       ? 0U
               : ring == rings ? static_cast<std::uint32_t>((rings - 1) * sides + 1)
                               : static_cast<std::uint32_t>((ring - 1) * sides + side % sides + 1);
    };
    for (int ring = open ? rings / 2 : 0; ring < rings; ++ring) {
        for (int side = 0; side < sides; ++side) {
            const std::uint32_t a = at(ring, side), b = at(ring + 1, side),
                                c = at(ring + 1, side + 1), d = at(ring, side + 1);
            if (ring + 1 < rings) {
                mesh.triangles.push_back({a, b, c});
            }
            if (ring > 0) {
                mesh.triangles.push_back({a, c, d});
            }
        }
    }
    return mesh;
}

/// Root mean square of the distances from the sphere, and the mean radius.
std::array<double, 2> roughness(const WeldedMesh& mesh) {
    double sum = 0, squares = 0;
    for (const glm::vec3& p : mesh.p_grid) {
        const double r = glm::distance(glm::dvec3(p), center);
        sum += r;
        squares += (r - radius) * (r - radius);
    }
    const auto count = static_cast<double>(mesh.p_grid.size());
    return {std::sqrt(squares / count), sum / count};
}

double volume_of(const WeldedMesh& mesh) {
    return certify(mesh, patient_grid()).volume_mm3;
}

}  // namespace

TEST_SUITE("surface/mesh_smooth") {
    TEST_CASE("ripples go, and size and volume stay") {
        const WeldedMesh rough = rough_sphere(0.4);
        WeldedMesh smooth = rough;
        const Smoothing changed = smooth_mesh(smooth, patient_grid(), 20);
        CHECK(smooth.triangles == rough.triangles);
        CHECK(roughness(smooth)[0] < roughness(rough)[0] / 3);
        CHECK(roughness(smooth)[1] == doctest::Approx(radius).epsilon(0.002));
        CHECK(volume_of(smooth) == doctest::Approx(volume_of(rough)).epsilon(0.004));
        CHECK(changed.volume_mm3 ==
              doctest::Approx(volume_of(smooth) - volume_of(rough)).epsilon(1e-3));
        CHECK(changed.farthest_mm < 1);
        CHECK(changed.mean_mm > 0.1);
        CHECK(changed.mean_mm < changed.farthest_mm);
        for (std::size_t v = 0; v < smooth.p_grid.size(); ++v) {
            const glm::dvec3 out = glm::normalize(glm::dvec3(smooth.p_grid[v]) - center);
            CHECK(glm::dot(out, glm::dvec3(smooth.normals[v])) >
                  0.8);  // Triangles at the poles are slivers.
            CHECK(glm::length(glm::dvec3(smooth.normals[v])) == doctest::Approx(1));
        }
    }

    TEST_CASE("what is smooth changes little after the most passes") {
        WeldedMesh mesh = rough_sphere(0);
        const double before = volume_of(mesh);
        const Smoothing changed = smooth_mesh(mesh, patient_grid(), max_smoothing);
        CHECK(volume_of(mesh) == doctest::Approx(before).epsilon(0.01));
        CHECK(changed.farthest_mm < 0.6);
    }

    TEST_CASE("a shape of 13 triangles stays") {
        WeldedMesh mesh = rough_sphere(0);
        const auto wave = [](const glm::vec3& p) {  // Six around the equator, none at the poles.
            const glm::dvec3 d = glm::dvec3(p) - center;
            const double flat = std::hypot(d.x, d.y) / radius;
            return std::pow(flat, 6) * std::cos(6 * std::atan2(d.y, d.x));
        };
        /// Height of the waves.
        const auto height = [&](const WeldedMesh& of) {
            double sum = 0, squares = 0;
            for (const glm::vec3& p : of.p_grid) {
                sum += (glm::distance(glm::dvec3(p), center) - radius) * wave(p);
                squares += wave(p) * wave(p);
            }
            return sum / squares;
        };
        for (glm::vec3& p : mesh.p_grid) {
            const glm::dvec3 out = glm::normalize(glm::dvec3(p) - center);
            p += glm::vec3(0.5 * wave(p) * out);
        }
        const double before = height(mesh);
        smooth_mesh(mesh, patient_grid(), max_smoothing);
        CHECK(height(mesh) / before > 0.9);
        CHECK(height(mesh) / before < 1.01);
    }

    TEST_CASE("ends of an open surface stay") {
        const WeldedMesh rough = rough_sphere(0.4, true);
        WeldedMesh smooth = rough;
        CHECK(smooth_mesh(smooth, patient_grid(), 50).mean_mm > 0);
        const std::size_t end = (rings / 2 - 1) * sides + 1;  // First vertex of the open ring.
        for (std::size_t v = end; v < end + sides; ++v) {
            CHECK(smooth.p_grid[v] == rough.p_grid[v]);
        }
    }

    TEST_CASE("no vertex leaves the box around the surface") {
        // A sheet with a step, beside which the filter overshoots.
        constexpr std::uint32_t side = 24;
        WeldedMesh sheet;
        for (std::uint32_t y = 0; y < side; ++y) {
            for (std::uint32_t x = 0; x < side; ++x) {
                sheet.keys.push_back(sheet.keys.size());
                sheet.p_grid.emplace_back(x, y, x < side / 2 ? 0 : 5);
                sheet.normals.emplace_back(0, 0, 1);
            }
        }
        for (std::uint32_t y = 0; y + 1 < side; ++y) {
            for (std::uint32_t x = 0; x + 1 < side; ++x) {
                const std::uint32_t a = y * side + x, b = a + 1, c = a + side;
                sheet.triangles.push_back({a, b, c});
                sheet.triangles.push_back({b, c + 1, c});
            }
        }
        const std::vector<glm::vec3> before = sheet.p_grid;
        CHECK(smooth_mesh(sheet, patient_grid(), 20).farthest_mm > 0.5);
        for (const glm::vec3& p : sheet.p_grid) {
            CHECK(p.z >= 0);
            CHECK(p.z <= 5);
        }
        CHECK(sheet.p_grid != before);
    }

    TEST_CASE("moves are in millimeters, in any grid") {
        const WeldedMesh rough = rough_sphere(0.4);
        WeldedMesh in_mm = rough, in_grid = rough;
        const Smoothing wanted = smooth_mesh(in_mm, patient_grid(), 20);
        VolumeGrid grid = patient_grid();
        grid.voxel_to_patient = glm::scale(glm::dmat4(1), glm::dvec3(2, 2, 2));
        const Smoothing twice = smooth_mesh(in_grid, grid, 20);
        CHECK(in_grid.p_grid == in_mm.p_grid);
        CHECK(twice.farthest_mm == doctest::Approx(2 * wanted.farthest_mm));
        CHECK(twice.mean_mm == doctest::Approx(2 * wanted.mean_mm));
        CHECK(twice.volume_mm3 == doctest::Approx(8 * wanted.volume_mm3));
    }

    TEST_CASE("normals and the change of the volume are right in a mirrored, uneven grid") {
        const glm::dvec3 steps(-2, 1, 0.5);
        WeldedMesh in_mm = rough_sphere(0.4), in_grid = in_mm;
        for (glm::vec3& p : in_mm.p_grid) {
            p = glm::vec3(steps * glm::dvec3(p));
        }
        for (WeldedMesh* mesh : {&in_mm, &in_grid}) {
            for (auto& triangle : mesh->triangles) {  // Counter-clockwise in the patient.
                std::swap(triangle[1], triangle[2]);
            }
        }
        VolumeGrid grid = patient_grid();
        grid.voxel_to_patient = glm::scale(glm::dmat4(1), steps);
        const double before = volume_of(in_mm);
        const Smoothing wanted = smooth_mesh(in_mm, patient_grid(), 10);
        CHECK(wanted.volume_mm3 == doctest::Approx(volume_of(in_mm) - before).epsilon(1e-3));
        const Smoothing got = smooth_mesh(in_grid, grid, 10);
        CHECK(got.volume_mm3 == doctest::Approx(wanted.volume_mm3).epsilon(1e-3));
        CHECK(got.farthest_mm == doctest::Approx(wanted.farthest_mm).epsilon(1e-4));
        for (std::size_t v = 0; v < in_grid.normals.size(); ++v) {
            const glm::dvec3 out = steps * (glm::dvec3(in_grid.p_grid[v]) - center);
            CHECK(glm::dot(out, glm::dvec3(in_grid.normals[v])) > 0);
            CHECK(glm::distance(in_grid.normals[v], in_mm.normals[v]) < 1e-3F);
        }
    }

    TEST_CASE("a surface without triangles has nothing to smooth") {
        WeldedMesh none;
        CHECK(smooth_mesh(none, patient_grid(), 5).farthest_mm == 0);
    }
}
