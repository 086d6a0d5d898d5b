// Oblique slices against fields that are linear in the patient, and a sphere.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/vec4.hpp>
#include <random>
#include <utility>

#include "host/phantom/phantom.hpp"
#include "host/scene/oblique.hpp"
#include "host/scene/slice_places.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

const glm::dvec3 rise(3, -7, 11);  // Of the field, per mm.

double field(const glm::dvec3& p_mm) {
    return 20 + glm::dot(rise, p_mm);
}

/// A volume of float32 whose voxels have the values of the field.
Volume field_volume(const glm::dmat4& voxel_to_patient, std::vector<double> slice_places) {
    Volume v;
    v.nx = 12;
    v.ny = 10;
    v.nz = 8;
    v.type = Scalar::float32;
    v.voxel_to_patient = voxel_to_patient;
    v.slice_places = std::move(slice_places);
    for (int i = 0; i < v.nx * v.ny * v.nz; ++i) {
        const int z = i / (v.nx * v.ny);
        const glm::dvec4 grid(i % v.nx, i / v.nx % v.ny, place_of_slice(z, v.slice_places), 1);
        const auto value = static_cast<float>(field(glm::dvec3(voxel_to_patient * grid)));
        const auto* bytes = reinterpret_cast<const std::byte*>(&value);
        v.values.insert(v.values.end(), bytes, bytes + sizeof value);
    }
    return v;
}

/// A random plane near the place, with a right angle between its sides.
ObliquePlane random_plane(std::mt19937& random, const glm::dvec3& near_mm) {
    std::uniform_real_distribution<double> any(-1, 1);
    const auto vector = [&] { return glm::dvec3(any(random), any(random), any(random)); };
    ObliquePlane plane;
    plane.center_mm = near_mm + vector() * 2.0;
    plane.right = glm::normalize(vector());
    plane.down = glm::normalize(glm::cross(plane.right, vector()));
    plane.width = 41;
    plane.height = 37;
    plane.pixel_mm = 0.43;
    return plane;
}

glm::dmat4 tilted() {
    glm::dmat4 m(1.0);
    m[0] = glm::dvec4(0.8, 0.1, 0, 0);
    m[1] = glm::dvec4(-0.1, 0.9, 0, 0);
    m[2] = glm::dvec4(0, 0.4, 1.5, 0);
    m[3] = glm::dvec4(-4, 5, -60, 1);
    return m;
}

}  // namespace

TEST_SUITE("oblique") {
    TEST_CASE("a field that is linear in the patient has its values at every pixel") {
        std::mt19937 random(test::seed_or<std::uint32_t>(5));
        for (const std::vector<double>& places :
             {std::vector<double>{}, std::vector<double>{0, 1, 2, 2.5, 4, 6, 6.5, 7}}) {
            const Volume volume = field_volume(tilted(), places);
            const glm::dvec3 middle(volume.voxel_to_patient * glm::dvec4(5.5, 4.5, 3.5, 1));
            std::size_t inside = 0;
            for (int each = 0; each < 40; ++each) {
                const ObliquePlane plane = random_plane(random, middle);
                const std::vector<float> values = oblique_values(volume, plane);
                REQUIRE(values.size() == 41 * 37);
                const glm::dmat4 to_grid = glm::inverse(volume.voxel_to_patient);
                for (int i = 0; i < 41 * 37; ++i) {
                    const glm::dvec3 p = place_mm(plane, i % 41, i / 41);
                    const glm::dvec4 g = to_grid * glm::dvec4(p, 1);
                    const bool is_in =
                        g.x >= 0 && g.x <= 11 && g.y >= 0 && g.y <= 9 && g.z >= 0 && g.z <= 7;
                    const float value = values[static_cast<std::size_t>(i)];
                    REQUIRE(std::isnan(value) == !is_in);
                    if (is_in) {
                        REQUIRE(value == doctest::Approx(field(p)).epsilon(1e-5));
                        ++inside;
                    }
                }
            }
            CHECK(inside > 10'000);
        }
    }
    TEST_CASE("angles of 0 and 90 degrees are the three planes as radiologists show them") {
        const Volume volume = field_volume(tilted(), {});
        struct Case {
            ObliqueAngles angles;
            glm::dvec3 right, down;
        };
        for (const Case& each :
             {Case{{0, 0}, {1, 0, 0}, {0, 1, 0}}, Case{{90, 0}, {1, 0, 0}, {0, 0, -1}},
              Case{{90, 90}, {0, 1, 0}, {0, 0, -1}}}) {
            const ObliquePlane plane = oblique_plane(volume, each.angles, {0, 0, 0}, 1);
            CHECK(glm::distance(plane.right, each.right) < 1e-12);
            CHECK(glm::distance(plane.down, each.down) < 1e-12);
        }
    }
    TEST_CASE("a plane goes through its place, and its picture shows the whole volume") {
        std::mt19937 random(test::seed_or<std::uint32_t>(11));
        std::uniform_real_distribution<double> angle(-180, 180), any(-20, 20);
        for (const std::vector<double>& places :
             {std::vector<double>{}, std::vector<double>{1, 2, 3, 3.5, 5, 7, 7.5, 8}}) {
            const Volume volume = field_volume(tilted(), places);
            for (int each = 0; each < 50; ++each) {
                const glm::dvec3 through =
                    middle_mm(volume) + glm::dvec3(any(random), any(random), any(random));
                const double least_mm = each % 2 == 0 ? 0.4 : 1e-3;
                const ObliquePlane plane =
                    oblique_plane(volume, {angle(random), angle(random)}, through, least_mm);
                const glm::dvec3 normal = glm::cross(plane.right, plane.down);
                REQUIRE(glm::length(normal) == doctest::Approx(1));
                REQUIRE(std::abs(glm::dot(normal, through - plane.center_mm)) < 1e-9);
                REQUIRE(plane.width == plane.height);
                REQUIRE(plane.width <= max_oblique_px);
                REQUIRE((plane.pixel_mm == least_mm) == (each % 2 == 0));
                for (unsigned corner = 0; corner < 8; ++corner) {
                    const double z = (corner & 4U) != 0 ? 7 : 0;
                    const glm::dvec4 grid((corner & 1U) != 0 ? 11 : 0, (corner & 2U) != 0 ? 9 : 0,
                                          place_of_slice(z, places), 1);
                    const glm::dvec3 p =
                        glm::dvec3(volume.voxel_to_patient * grid) - plane.center_mm;
                    const double half = plane.width * plane.pixel_mm / 2 + 1e-9;
                    REQUIRE(std::abs(glm::dot(p, plane.right)) <= half);
                    REQUIRE(std::abs(glm::dot(p, plane.down)) <= half);
                }
            }
        }
    }
    TEST_CASE("a plane meets the volume between its outermost corners") {
        const Volume volume = field_volume(tilted(), {});
        const glm::dvec3 middle = middle_mm(volume);
        // Along z, the middles of the voxels are up to 5.25 mm from the middle of the volume.
        for (const auto& [off_mm, expected] :
             {std::pair{0.0, true}, {5.2, true}, {-5.2, true}, {5.3, false}, {-5.3, false}}) {
            const glm::dvec3 through = middle + glm::dvec3(0, 0, off_mm);
            CHECK(meets(oblique_plane(volume, {0, 0}, through, 1), volume) == expected);
        }
    }
    TEST_CASE("a plane on a slice has the values of its voxels, and its letters") {
        const Volume sphere = make_phantom("phantom:sphere");
        const Slice slice = slice_of(sphere, 2, 20);
        const std::vector<double> exact = numbers_of(slice);
        ObliquePlane plane;  // A row: columns and rows have different spacings.
        plane.width = sphere.nx;
        plane.pixel_mm = slice.frame.across.spacing_mm;
        plane.center_mm =
            glm::dvec3(sphere.voxel_to_patient * glm::dvec4((sphere.nx - 1) / 2.0, 30, 20, 1));
        const std::vector<float> values = oblique_values(sphere, plane);
        REQUIRE(!slice.frame.down.is_flipped);
        for (std::size_t x = 0; x < values.size(); ++x) {
            REQUIRE(values[x] == exact[30 * values.size() + x]);
        }
        plane.right = glm::normalize(glm::dvec3(1, 0, 1));
        plane.down = glm::dvec3(0, 1, 0);
        const SliceFrame frame = oblique_frame(plane);
        CHECK(frame.across.begin == "RI");
        CHECK(frame.across.end == "LS");
        CHECK(frame.down.end == "P");
    }
    TEST_CASE("the contour of a sphere is a circle on any plane") {
        const Volume sphere = make_phantom("phantom:sphere");
        const glm::dvec3 center(0.3, -0.7, 0.45);  // Radius 30 mm, as the phantom is documented.
        std::mt19937 random(test::seed_or<std::uint32_t>(7));
        for (int each = 0; each < 20; ++each) {
            ObliquePlane plane = random_plane(random, center);
            plane.width = plane.height = 160;
            plane.pixel_mm = 0.5;
            const glm::dvec3 normal = glm::cross(plane.right, plane.down);
            plane.center_mm += normal * 15.0;
            const double off = glm::dot(normal, plane.center_mm - center);
            const auto pieces = oblique_contour(plane, oblique_values(sphere, plane), 0.5);
            double length = 0;
            for (const ContourPiece& piece : pieces) {
                length += glm::length(glm::dvec2(piece.to) - glm::dvec2(piece.from)) * 0.5;
                const double radius =
                    glm::length(place_mm(plane, piece.from.x, piece.from.y) - center);
                REQUIRE(std::abs(radius - 30) < 0.1);
            }
            CHECK(
                length ==
                doctest::Approx(2 * glm::pi<double>() * std::sqrt(900 - off * off)).epsilon(0.01));
        }
    }
    TEST_CASE("no contour runs along the border of the volume") {
        const Volume volume = field_volume(glm::dmat4(1.0), {});
        ObliquePlane plane;
        plane.center_mm = {5.5, 4.5, 3.2};
        plane.width = plane.height = 40;
        const std::vector<float> values = oblique_values(volume, plane);
        CHECK(oblique_contour(plane, values, -1000).empty());
        const auto pieces = oblique_contour(plane, values, field({5.5, 4.5, 3.2}));
        REQUIRE(!pieces.empty());
        for (const ContourPiece& piece : pieces) {
            const double value = field(place_mm(plane, piece.from.x, piece.from.y));
            REQUIRE(value == doctest::Approx(field({5.5, 4.5, 3.2})));
        }
    }
}
