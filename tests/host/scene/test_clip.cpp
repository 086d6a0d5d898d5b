// Clip planes in patient space and in the grid: the same side, whatever the volume's axes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <random>
#include <vector>

#include "host/scene/clip.hpp"
#include "host/scene/slice_places.hpp"

using namespace pxpl5::host;

namespace {

constexpr double pi = 3.14159265358979323846;

/// Spacings, a turn, a shift; with a tilted gantry's shear, and mirrored.
glm::dmat4 oblique(double turn_rad, double shear, bool mirrored) {
    const double c = std::cos(turn_rad), s = std::sin(turn_rad);
    glm::dmat4 m(1.0);
    m[0] = glm::dvec4(glm::dvec3(c, s, 0) * 0.7, 0);
    m[1] = glm::dvec4(glm::dvec3(-s, c, 0) * (mirrored ? -1.1 : 1.1), 0);
    m[2] = glm::dvec4(0, shear, 2.5, 0);
    m[3] = glm::dvec4(-40, 25, 310, 1);
    return m;
}

double side(const glm::dvec4& plane, const glm::dvec3& p) {
    return glm::dot(plane, glm::dvec4(p, 1));
}

bool keeps(const BoxPlanes& planes, const glm::dvec3& p) {
    return std::ranges::all_of(planes,
                               [&](const glm::dvec4& plane) { return side(plane, p) >= 0; });
}

}  // namespace

TEST_CASE("a point is on the same side of a plane in the grid as in the patient") {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> number(-60, 60);
    const auto vector = [&] { return glm::dvec3(number(random), number(random), number(random)); };
    for (const bool mirrored : {false, true}) {
        for (const double shear : {0.0, 0.6}) {
            const glm::dmat4 to_patient = oblique(0.2 * pi, shear, mirrored);
            for (int n = 0; n < 300; ++n) {
                const glm::dvec3 point_mm = vector() + glm::dvec3(-40, 25, 310);
                const glm::dvec3 normal = vector();
                const glm::dvec4 plane = plane_through(point_mm, normal);
                const glm::dvec4 grid = grid_plane(plane, to_patient);
                CHECK(glm::length(glm::dvec3(grid)) == doctest::Approx(1));
                const glm::dvec3 p_grid = vector();
                const glm::dvec3 p_mm(to_patient * glm::dvec4(p_grid, 1));
                const double in_patient = glm::dot(normal, p_mm - point_mm);
                if (std::abs(in_patient) > 1e-9) {
                    CHECK((side(grid, p_grid) > 0) == (in_patient > 0));
                    CHECK((side(plane, p_mm) > 0) == (in_patient > 0));
                }
                // The plane's own point lies on it.
                const glm::dvec3 on(glm::inverse(to_patient) * glm::dvec4(point_mm, 1));
                CHECK(std::abs(side(grid, on)) < 1e-9);
                CHECK(glm::distance(patient_plane(grid, to_patient), plane) < 1e-9);
            }
        }
    }
}

TEST_CASE("a letter keeps what lies farther that way") {
    struct Case {
        char letter;
        double at_mm;
        glm::dvec3 kept, cut;
    };
    for (const Case& c :
         {Case{'L', 5, {6, 0, 0}, {4, 0, 0}}, Case{'R', 5, {-6, 0, 0}, {-4, 0, 0}},
          Case{'P', 5, {0, 6, 0}, {0, 4, 0}}, Case{'A', 5, {0, -6, 0}, {0, -4, 0}},
          Case{'S', -5, {0, 0, -4}, {0, 0, -6}}, Case{'I', -5, {0, 0, 4}, {0, 0, 6}}}) {
        CAPTURE(c.letter);
        const glm::dvec4 plane = axis_plane(c.letter, c.at_mm).value();
        CHECK(side(plane, c.kept) > 0);
        CHECK(side(plane, c.cut) < 0);
    }
    for (const char letter : {'X', 'l', ' '}) {
        CHECK_FALSE(axis_plane(letter, 0).has_value());
    }
}

TEST_CASE("a box keeps what lies in it, in millimeters and in voxels") {
    const glm::dmat4 to_patient = oblique(-0.1 * pi, 0.3, true);
    const BoxPlanes in_mm = box_planes_voxels({-50, 10, 300}, {-20, 40, 330}, {});
    const std::vector<double> places = {0, 1, 4, 5, 5.5, 9};
    const BoxPlanes in_voxels = box_planes_voxels({3, 4, 1.5}, {10, 12, 4.5}, {to_patient, places});
    std::mt19937 random(8);
    std::uniform_real_distribution<double> x(-60, 60), z(-10, 30);
    int kept = 0;
    for (int n = 0; n < 20000; ++n) {
        const glm::dvec3 p(x(random), x(random), z(random));
        const glm::dvec3 mm(to_patient * glm::dvec4(p, 1));
        const bool in =
            mm.x >= -50 && mm.x <= -20 && mm.y >= 10 && mm.y <= 40 && mm.z >= 300 && mm.z <= 330;
        REQUIRE(keeps(in_mm, mm) == in);
        kept += in ? 1 : 0;
        // Between slices 1 and 2, which lie at 1 and 4, half-way is 2.5; between 4 and 5 it
        // is 7.25.
        REQUIRE(keeps(in_voxels, mm) ==
                (p.x >= 3 && p.x <= 10 && p.y >= 4 && p.y <= 12 && p.z >= 2.5 && p.z <= 7.25));
    }
    CHECK(kept > 100);
}

TEST_CASE("slices and their places are each other's inverses, beyond the ends too") {
    const std::vector<double> places = {0, 1, 4, 5, 5.5, 9};
    CHECK(place_of_slice(2, places) == 4);
    CHECK(place_of_slice(1.5, places) == 2.5);
    CHECK(place_of_slice(-2, places) == -2);  // The first spacing is 1.
    CHECK(place_of_slice(7, places) == 16);   // The last is 3.5.
    CHECK(slice_of_place(9, places) == 5);
    CHECK(slice_of_place(0, places) == 0);
    CHECK(place_of_slice(2.25, {}) == 2.25);
    CHECK(slice_of_place(2.25, {}) == 2.25);
    for (double slice = -3; slice < 9; slice += 0.125) {
        CHECK(slice_of_place(place_of_slice(slice, places), places) == doctest::Approx(slice));
    }
}

TEST_CASE("what is no plane, or no box, is refused by name") {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_WITH(plane_through({0, 0, 0}, {0, 0, 0}),
                      "clip plane: its normal (0, 0, 0) has no length");
    CHECK_THROWS_WITH(plane_through({0, nan, 0}, {0, 0, 1}),
                      "clip plane: its point (0, nan, 0) is not finite");
    CHECK_THROWS_WITH(box_planes_voxels({0, 5, 0}, {1, 5, 1}, {}),
                      "clip box: y runs from 5 to 5 voxels; the first must be less");
    CHECK_THROWS_WITH(box_planes_voxels({0, 0, 9}, {1, 5, 1}, {}),
                      "clip box: z runs from 9 to 1 voxels; the first must be less");
}
