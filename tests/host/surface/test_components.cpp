// A surface taken apart, parts of it shown, and points found on it.
#include <doctest/doctest.h>

#include <algorithm>
#include <numbers>

#include "host/base/error.hpp"
#include "host/surface/components.hpp"
#include "host/surface/mesh_mask.hpp"
#include "tests/host/surface/surface_support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using host::ComponentMeasure;
using host::find_components;
using host::MeshComponent;
using host::MeshComponents;
using host::Shown;
using host::WeldedMesh;

namespace {

constexpr double pi = std::numbers::pi;
const glm::dmat3 steps{0.9, 0, 0, 0, 1.1, 0, 0, 0, 1.3};

struct Ball {
    glm::dvec3 center_mm;
    double radius_mm;
};
const std::vector<Ball> balls = {{{-14, 2, 1}, 9}, {{9, -3, 0}, 5}, {{18, 4, 2}, 3}};

/// Relative error of a ball's area or volume: its mesh is inscribed, with sides of up to a
/// voxel, 1.3 mm.
double chord_error(double radius_mm) {
    return 1.3 * 1.3 / (radius_mm * radius_mm) / 2;
}

/// Depth within the nearest ball.
double depth_mm(glm::dvec3 p_mm) {
    double depth = -1000;
    for (const Ball& ball : balls)
        depth = std::max(depth, ball.radius_mm - glm::distance(p_mm, ball.center_mm));
    return depth;
}

Parts three_balls() {
    return parts_of(placed_volume({56, 32, 24}, steps, depth_mm), 0);
}

std::size_t count(const Shown& shown) {
    return static_cast<std::size_t>(std::count(shown.begin(), shown.end(), 1));
}

}  // namespace

TEST_SUITE("host/surface/components") {
    TEST_CASE("three balls are three components with their areas, volumes, boxes and centers") {
        const Parts p = three_balls();
        REQUIRE(p.parts.components.size() == 3);
        std::size_t triangles = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const MeshComponent& c = p.parts.components[i];
            const double r = balls[i].radius_mm;
            triangles += c.triangles;
            CHECK(c.closed);
            CHECK(c.area_mm2 == doctest::Approx(4 * pi * r * r).epsilon(chord_error(r)));
            CHECK(c.volume_mm3.value() ==
                  doctest::Approx(4 * pi / 3 * r * r * r).epsilon(chord_error(r)));
            CHECK(glm::distance(c.center_mm, balls[i].center_mm) < 0.02);
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(c.bounds_mm.low[axis] ==
                      doctest::Approx(balls[i].center_mm[axis] - r).epsilon(0.03));
                CHECK(c.bounds_mm.high[axis] ==
                      doctest::Approx(balls[i].center_mm[axis] + r).epsilon(0.03));
            }
            CHECK(p.parts.of_triangle[c.first_triangle] == i);
            CHECK(std::find(p.parts.of_triangle.begin(), p.parts.of_triangle.end(), i) -
                      p.parts.of_triangle.begin() ==
                  static_cast<std::ptrdiff_t>(c.first_triangle));
        }
        CHECK(triangles == p.mesh.triangles.size());
    }

    TEST_CASE("a cavity is a component of negative volume") {
        const Volume volume = placed_volume(
            {30, 28, 24}, steps, [](glm::dvec3 p) { return 4 - std::abs(glm::length(p) - 7); });
        const Parts p = parts_of(volume, 0);
        REQUIRE(p.parts.components.size() == 2);
        const double outer = 4 * pi / 3 * 11 * 11 * 11, inner = 4 * pi / 3 * 3 * 3 * 3;
        CHECK(p.parts.components[0].volume_mm3.value() ==
              doctest::Approx(outer).epsilon(chord_error(11)));
        CHECK(p.parts.components[1].volume_mm3.value() ==
              doctest::Approx(-inner).epsilon(chord_error(3)));
        const auto whole = host::certify(p.mesh, p.grid);
        CHECK(whole.volume_mm3 == doctest::Approx(p.parts.components[0].volume_mm3.value() +
                                                  p.parts.components[1].volume_mm3.value()));
    }

    TEST_CASE("a cavity that the border cuts has its own volume, negative") {
        const Volume volume = make_volume({20, 16, 14}, Scalar::float32, [](int x, int y, int z) {
            return glm::distance(glm::dvec3(x, y, z), glm::dvec3(19, 15, 13)) - 6;
        });
        const Parts p = parts_of(volume, 0);
        REQUIRE(p.parts.components.size() == 1);
        CHECK(p.parts.components[0].volume_mm3.value() ==
              doctest::Approx(-pi / 6 * 6 * 6 * 6).epsilon(chord_error(6)));
    }

    TEST_CASE(
        "a component that the border cuts has the volume within, and one with holes has none") {
        const Volume volume = make_volume({20, 16, 14}, Scalar::float32, [](int x, int y, int z) {
            const glm::dvec3 p(x, y, z);
            return std::max(6 - glm::distance(p, glm::dvec3(19, 15, 13)),
                            3 - glm::distance(p, glm::dvec3(5, 6, 7)));
        });
        Parts p = parts_of(volume, 0);
        REQUIRE(p.parts.components.size() == 2);
        const MeshComponent& cut = p.parts.components[p.parts.components[0].closed ? 1 : 0];
        const MeshComponent& whole = p.parts.components[p.parts.components[0].closed ? 0 : 1];
        CHECK_FALSE(cut.closed);
        CHECK(cut.volume_mm3.value() ==
              doctest::Approx(pi / 6 * 6 * 6 * 6).epsilon(chord_error(6)));
        CHECK(whole.volume_mm3.value() == doctest::Approx(4 * pi / 3 * 27).epsilon(chord_error(3)));
        const std::size_t gone = whole.first_triangle;
        Shown shown(p.mesh.triangles.size(), 1);
        shown[gone] = 0;
        const auto torn = find_components(host::shown_part(p.mesh, shown), p.grid);
        CHECK(torn.components.size() == 2);
        CHECK(std::count_if(torn.components.begin(), torn.components.end(),
                            [](const MeshComponent& c) { return c.volume_mm3.has_value(); }) == 1);
    }

    TEST_CASE("equal components are numbered by their lowest triangle") {
        const Volume volume = make_volume({9, 3, 9}, Scalar::int16, [](int x, int y, int z) {
            return x % 2 == 1 && y == 1 && z % 2 == 1 ? 1.0 : 0.0;
        });
        const Parts p = parts_of(volume, 1);
        REQUIRE(p.parts.components.size() == 16);
        for (std::size_t i = 0; i < 16; ++i) {
            const MeshComponent& c = p.parts.components[i];
            CHECK(c.triangles == 8);
            if (i > 0) CHECK(c.first_triangle > p.parts.components[i - 1].first_triangle);
            CHECK(c.center_mm.x == 1 + 2 * double(i % 4));
            CHECK(c.center_mm.z == 1 + 2 * double(i / 4));
        }
    }

    TEST_CASE("components are shown by number, or by what they have at least") {
        const Parts p = three_balls();
        const auto& c = p.parts.components;
        const Shown largest = show_component(p.parts, 0);
        CHECK(count(largest) == c[0].triangles);
        for (std::size_t t = 0; t < largest.size(); ++t)
            CHECK(largest[t] == (p.parts.of_triangle[t] == 0 ? 1 : 0));
        const auto shown = [&](ComponentMeasure measure, double least) {
            const std::size_t triangles = count(show_at_least(p.parts, measure, least));
            CHECK((triangles == c[0].triangles || triangles == c[0].triangles + c[1].triangles));
            return triangles == c[0].triangles ? 1 : 2;
        };
        CHECK(shown(ComponentMeasure::triangles, double(c[1].triangles)) == 2);
        CHECK(shown(ComponentMeasure::triangles, double(c[1].triangles) + 1) == 1);
        CHECK(shown(ComponentMeasure::area_mm2, 4 * pi * 16) == 2);
        CHECK(shown(ComponentMeasure::area_mm2, 4 * pi * 36) == 1);
        CHECK(shown(ComponentMeasure::volume_ml, 4 * pi / 3 * 64 / 1000) == 2);
        CHECK(shown(ComponentMeasure::volume_ml, 4 * pi / 3 * 216 / 1000) == 1);
        try {
            show_component(p.parts, 3);
            FAIL("nothing was thrown");
        } catch (const host::RequestError& error) {
            CHECK(std::string(error.what()) == "component 4: the surface has 3");
        }
    }

    TEST_CASE("a shown part is a mesh of its own, with the normals and cells of its triangles") {
        const Parts p = three_balls();
        const Shown shown = show_component(p.parts, 1);
        const WeldedMesh part = shown_part(p.mesh, shown);
        const auto certificate = host::certify(part, p.grid);
        CHECK(certificate.closed());
        CHECK(certificate.good());
        CHECK(certificate.genus() == 0);
        CHECK(certificate.area_mm2 == doctest::Approx(p.parts.components[1].area_mm2));
        CHECK(std::is_sorted(part.keys.begin(), part.keys.end()));
        REQUIRE(part.slabs.size() == p.mesh.slabs.size());
        std::size_t at = 0;
        for (std::size_t s = 0; s < part.slabs.size(); ++s) {
            CHECK(part.slabs[s].slab == p.mesh.slabs[s].slab);
            CHECK(part.slabs[s].first == at);
            const auto& slab = p.mesh.slabs[s];
            for (std::size_t t = slab.first; t < slab.first + slab.count; ++t) {
                if (shown[t] == 0) continue;
                CHECK(part.cells[at].i == p.mesh.cells[t].i);
                for (std::size_t c = 0; c < 3; ++c) {
                    const std::uint32_t from = p.mesh.triangles[t][c];
                    const std::uint32_t to = part.triangles[at][c];
                    CHECK(part.keys[to] == p.mesh.keys[from]);
                    CHECK(part.p_grid[to] == p.mesh.p_grid[from]);
                    CHECK(part.normals[to] == p.mesh.normals[from]);
                }
                ++at;
            }
            CHECK(part.slabs[s].count == at - part.slabs[s].first);
        }
        CHECK(at == part.triangles.size());
    }

    TEST_CASE("a mask hides the triangles that are not shown, slab by slab") {
        const Parts p = three_balls();
        const Shown shown = show_component(p.parts, 2);
        const bus::Payload payload = host::mask_message(p.mesh, shown, 5, 9);
        const auto* mask = bus::schema::GetMessage(payload.bytes().data())->body_as_MaskSurface();
        REQUIRE(mask != nullptr);
        CHECK(mask->surface() == 5);
        CHECK(mask->revision() == 9);
        std::vector<std::uint8_t> hidden(p.mesh.triangles.size());
        for (const auto* slab : *mask->slabs()) {
            const auto& triangles = p.mesh.slabs[slab->slab()];
            REQUIRE(slab->hidden()->size() == (triangles.count + 7) / 8);
            for (std::size_t t = 0; t < 8 * std::size_t{slab->hidden()->size()}; ++t) {
                const auto byte = slab->hidden()->Get(static_cast<flatbuffers::uoffset_t>(t / 8));
                const bool bit = (byte >> t % 8 & 1) != 0;
                if (t < triangles.count)
                    hidden[triangles.first + t] = bit ? 1 : 0;
                else
                    CHECK_FALSE(bit);
            }
        }
        for (std::size_t t = 0; t < shown.size(); ++t) CHECK(hidden[t] == (shown[t] ? 0 : 1));
        // Slabs with nothing to hide are not named.
        const Shown all(p.mesh.triangles.size(), 1);
        const bus::Payload none = host::mask_message(p.mesh, all, 5, 9);
        CHECK(
            bus::schema::GetMessage(none.bytes().data())->body_as_MaskSurface()->slabs()->size() ==
            0);
    }

    TEST_CASE("the nearest point is on the ball that is nearest, where the line to it pierces it") {
        const Parts p = three_balls();
        const glm::dvec3 outside(9, -3, 9), inside(-12, 2, 1);
        const auto above = host::nearest_point(p.mesh, p.grid, outside);
        REQUIRE(above);
        CHECK(p.parts.of_triangle[above->triangle] == 1);
        CHECK(above->distance_mm == doctest::Approx(4).epsilon(0.03));
        CHECK(glm::distance(above->p_mm, glm::dvec3(9, -3, 5)) < 0.6);
        const auto within = host::nearest_point(p.mesh, p.grid, inside);
        CHECK(p.parts.of_triangle[within->triangle] == 0);
        CHECK(within->distance_mm == doctest::Approx(7).epsilon(0.03));
        CHECK_FALSE(host::nearest_point(WeldedMesh{}, p.grid, inside));
        // No point of any triangle is nearer: corners, middles of sides and of triangles.
        const unsigned seed = seed_or(8U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> place(-25, 25);
        for (int i = 0; i < 20; ++i) {
            const glm::dvec3 q(place(random), place(random), place(random));
            const auto found = host::nearest_point(p.mesh, p.grid, q);
            CHECK(glm::distance(found->p_mm, q) == doctest::Approx(found->distance_mm));
            double least = 1e9;
            for (const auto& [a, b, c] : p.mesh.triangles)
                for (int u = 0; u <= 4; ++u)
                    for (int v = 0; u + v <= 4; ++v) {
                        const glm::dvec3 at = (double(u) * glm::dvec3(p.mesh.p_grid[a]) +
                                               double(v) * glm::dvec3(p.mesh.p_grid[b]) +
                                               double(4 - u - v) * glm::dvec3(p.mesh.p_grid[c])) /
                                              4.0;
                        least = std::min(least, glm::distance(p.grid.p_mm(at), q));
                    }
            CHECK(found->distance_mm <= least + 1e-9);
            CHECK(found->distance_mm > least - 0.2);
        }
    }
}
