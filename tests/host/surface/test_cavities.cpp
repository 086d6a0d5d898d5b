// Cavities: the components around them, and what is shown of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

#include "host/surface/parts/own_volume.hpp"
#include "tests/host/surface/surface_support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using host::ComponentMeasure;
using host::MeshComponent;
using host::Shown;
using host::WeldedMesh;

namespace {

const glm::dmat3 steps{0.9, 0, 0, 0, 1.1, 0, 0, 0, 1.3};

/// Numbers of the solids that voxels belong to, over 6 neighbors; -1 outside.
std::vector<int> solids_of(const Volume& volume, double isovalue) {
    const auto nx = volume.shape.nx, ny = volume.shape.ny, nz = volume.shape.nz;
    const auto size = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny * nz);
    std::vector<int> solid(size, -1);
    const auto* values = reinterpret_cast<const std::int16_t*>(volume.values.data());
    int count = 0;
    for (std::size_t start = 0; start < size; ++start) {
        if (solid[start] != -1 || values[start] < isovalue) continue;
        std::vector<std::size_t> waiting = {start};
        solid[start] = count;
        while (!waiting.empty()) {
            const auto at = static_cast<int>(waiting.back());
            waiting.pop_back();
            const int x = at % nx, y = at / nx % ny, z = at / nx / ny;
            const auto visit = [&](bool exists, int next) {
                const auto index = static_cast<std::size_t>(next);
                if (!exists || solid[index] != -1 || values[index] < isovalue) return;
                solid[index] = count;
                waiting.push_back(index);
            };
            visit(x > 0, at - 1);
            visit(x + 1 < nx, at + 1);
            visit(y > 0, at - nx);
            visit(y + 1 < ny, at + nx);
            visit(z > 0, at - nx * ny);
            visit(z + 1 < nz, at + nx * ny);
        }
        ++count;
    }
    return solid;
}

std::size_t count(const Shown& shown) {
    return static_cast<std::size_t>(std::count(shown.begin(), shown.end(), 1));
}

}  // namespace

TEST_SUITE("host/surface/cavities") {
    TEST_CASE("cavities are shown with the component around them, and never for themselves") {
        // A ball in a shell in a shell, each with a cavity: solid at 9.5 .. 12, 4 .. 7 and 0
        // .. 1.5.
        const Volume volume = placed_volume({34, 30, 26}, steps, [](glm::dvec3 p) {
            const double r = glm::length(p);
            return std::max({1.25 - std::abs(r - 10.75), 1.5 - std::abs(r - 5.5), 1.5 - r});
        });
        const Parts p = parts_of(volume, 0);
        const auto& c = p.parts.components;
        REQUIRE(c.size() == 5);
        const std::array<bool, 5> cavity = {false, true, false, true, false};
        for (std::size_t i = 0; i < 5; ++i) {
            CAPTURE(i);
            CHECK(c[i].cavity == cavity[i]);
            CHECK(c[i].cavity_of.has_value() == cavity[i]);
        }
        CHECK(c[1].cavity_of == 0U);
        CHECK(c[3].cavity_of == 2U);
        const auto shown = [&](const Shown& triangles) {
            std::vector<std::size_t> numbers;
            for (std::size_t i = 0; i < 5; ++i)
                if (triangles[c[i].first_triangle] != 0) numbers.push_back(i);
            return numbers;
        };
        using Numbers = std::vector<std::size_t>;
        using host::Cavities;
        constexpr auto ml = ComponentMeasure::volume_ml;
        CHECK(host::largest_component(p.parts) == 0);
        CHECK(shown(show_component(p.parts, 0)) == Numbers{0, 1});
        CHECK(shown(show_component(p.parts, 0, Cavities::filled)) == Numbers{0});
        CHECK(shown(show_component(p.parts, 3)) == Numbers{3});
        // 7.2, -3.6, 1.4, -0.27 and 0.014 ml.
        CHECK(shown(show_at_least(p.parts, ml, 5)) == Numbers{0, 1});
        CHECK(shown(show_at_least(p.parts, ml, 2)) == Numbers{0, 1});
        CHECK(shown(show_at_least(p.parts, ml, 0.5)) == Numbers{0, 1, 2, 3});
        CHECK(shown(show_at_least(p.parts, ml, 0.5, Cavities::filled)) == Numbers{0, 2});
        const auto certificate =
            host::certify(shown_part(p.mesh, show_component(p.parts, 0)), p.grid);
        CHECK(certificate.volume_mm3 ==
              doctest::Approx(c[0].volume_mm3.value() + c[1].volume_mm3.value()));
        const auto volume_mm3 = [&](std::size_t i) {
            return own_volume(p.parts, i).volume_mm3.value();
        };
        CHECK(volume_mm3(0) == doctest::Approx(certificate.volume_mm3));
        CHECK(volume_mm3(1) == -c[1].volume_mm3.value());
        CHECK(volume_mm3(4) == c[4].volume_mm3.value());
        // Shells and balls of these radii; the mesh cuts their curves.
        const auto ball_mm3 = [](double r) { return 4.0 / 3.0 * std::numbers::pi * r * r * r; };
        CHECK(volume_mm3(0) == doctest::Approx(ball_mm3(12) - ball_mm3(9.5)).epsilon(0.03));
        CHECK(volume_mm3(3) == doctest::Approx(ball_mm3(4)).epsilon(0.05));
    }

    TEST_CASE("a slab between two open components has the volume between them, asked of either") {
        for (const auto& [low, high] : {std::pair(9.0, 11.0), std::pair(1.0, 9.0),
                                        std::pair(2.0, 18.0), std::pair(9.0, 16.0)}) {
            CAPTURE(low);
            const Volume volume =
                make_volume({21, 6, 5}, Scalar::float32, [low = low, high = high](int x, int, int) {
                    return std::min(x - low, high - x) + 0.25;  // 0.25 further out.
                });
            const Parts p = parts_of(volume, 0);
            REQUIRE(p.parts.components.size() == 2);
            const double slab_mm3 = p.parts.box_mm3 * (high - low + 0.5) / 20;
            for (std::size_t i = 0; i < 2; ++i) {
                const auto [component, volume_mm3] = own_volume(p.parts, i);
                const double outside_mm3 = -p.parts.components[i].volume_mm3.value_or(0);
                // Beside a slab in the larger half, the other face is a cavity of it.
                const bool is_hollow = p.parts.components[component].cavity;
                CHECK(volume_mm3.value() ==
                      doctest::Approx(is_hollow ? outside_mm3 : slab_mm3).epsilon(1e-6));
            }
        }
    }

    TEST_CASE("a component with holes in it, or beside an open one, has no volume of its own") {
        // A shell with a ball in its cavity.
        const Volume volume = placed_volume({30, 30, 26}, steps, [](glm::dvec3 p) {
            const double r = glm::length(p);
            return std::max(1.25 - std::abs(r - 9.25), 3 - r);
        });
        Parts p = parts_of(volume, 0);
        REQUIRE(p.parts.components.size() == 3);
        CHECK(own_volume(p.parts, 0).volume_mm3.has_value());
        WeldedMesh torn = p.mesh;
        const std::size_t inner = p.parts.components[2].first_triangle;
        torn.triangles.erase(torn.triangles.begin() + static_cast<std::ptrdiff_t>(inner));
        const auto parts = find_components(torn, p.grid);
        REQUIRE(parts.components.size() == 3);
        CHECK_FALSE(own_volume(parts, 0).volume_mm3.has_value());  // The ball lies in it.
        CHECK_FALSE(own_volume(parts, 2).volume_mm3.has_value());
        CHECK(parts.components[1].cavity);
        CHECK(own_volume(parts, 1).volume_mm3.has_value());
    }

    TEST_CASE("the component around a cavity bounds the same solid voxels") {
        const unsigned seed = seed_or(5U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        int owners = 0, open_owners = 0;
        for (int round = 0; round < 40; ++round) {
            const Volume volume = make_volume({11, 9, 8}, Scalar::int16, [&](int x, int y, int z) {
                const bool is_far = round % 2 == 0 || (x > 0 && y > 0 && z > 0);
                return is_far ? double(random() % 8) : 0.0;
            });
            const double isovalue = 0.5 + round / 2 % 4;  // 7/8 to 4/8 of the voxels are inside.
            const Parts p = parts_of(volume, isovalue);
            const std::vector<int> solid = solids_of(volume, isovalue);
            // Every vertex of a component has an end of its edge in the same solid.
            std::vector<int> solid_of(p.parts.components.size(), -1);
            for (std::size_t t = 0; t < p.mesh.triangles.size(); ++t) {
                const std::uint64_t key = p.mesh.keys[p.mesh.triangles[t][0]];
                const std::uint64_t step[] = {1, 11, 11 * 9};
                const int found = std::max(solid[key / 4], solid[key / 4 + step[key % 4]]);
                int& known = solid_of[p.parts.of_triangle[t]];
                REQUIRE((known == -1 || known == found));
                known = found;
            }
            for (std::size_t i = 0; i < p.parts.components.size(); ++i) {
                const MeshComponent& c = p.parts.components[i];
                if (!c.cavity_of) {
                    const auto is_around = [&](std::size_t other) {
                        const MeshComponent& outer = p.parts.components[other];
                        return outer.closed && !outer.cavity && solid_of[other] == solid_of[i];
                    };
                    for (std::size_t other = 0; c.cavity && other < solid_of.size(); ++other) {
                        CHECK_FALSE(is_around(other));
                    }
                    continue;
                }
                REQUIRE(c.cavity);
                CHECK_FALSE(p.parts.components[*c.cavity_of].cavity);
                CHECK(solid_of[i] == solid_of[*c.cavity_of]);
                ++(c.closed ? owners : open_owners);
            }
        }
        CHECK(owners > 20);
        CHECK(open_owners > 20);
    }

    TEST_CASE("a cavity in a solid that fills the borders is a cavity of no component") {
        const Volume volume = make_volume({12, 12, 12}, Scalar::float32, [](int x, int y, int z) {
            return glm::distance(glm::dvec3(x, y, z), glm::dvec3(5, 6, 6)) - 3;
        });
        const Parts p = parts_of(volume, 0);
        REQUIRE(p.parts.components.size() == 1);
        CHECK(p.parts.components[0].cavity);
        CHECK_FALSE(p.parts.components[0].cavity_of.has_value());
        CHECK(host::largest_component(p.parts) == 0);
        CHECK(count(show_at_least(p.parts, ComponentMeasure::volume_ml, 0.1)) ==
              p.mesh.triangles.size());
    }

    TEST_CASE("a cavity in a solid with the first voxel belongs to the largest open component") {
        const Volume volume = make_volume({20, 12, 12}, Scalar::float32, [](int x, int y, int z) {
            const glm::dvec3 p(x, y, z);
            return std::min(14.25 - x, glm::distance(p, glm::dvec3(6, 6, 6)) - 3);
        });
        const Parts p = parts_of(volume, 0);
        REQUIRE(p.parts.components.size() == 2);
        const std::size_t cavity = p.parts.components[0].cavity ? 0 : 1;
        CHECK(p.parts.components[cavity].cavity_of == 1U - cavity);
        CHECK(host::largest_component(p.parts) == 1 - cavity);
    }

    TEST_CASE("a cavity that the border cuts is a cavity of the component around it") {
        // A tube along z, cut at both ends: solid at 2.5 .. 6 from its axis.
        const Volume volume = placed_volume({24, 22, 9}, steps, [](glm::dvec3 p) {
            return 1.75 - std::abs(std::hypot(p.x, p.y) - 4.25);
        });
        const Parts p = parts_of(volume, 0);
        const auto& c = p.parts.components;
        REQUIRE(c.size() == 2);
        CHECK_FALSE(c[0].cavity);
        CHECK(c[1].cavity);
        CHECK_FALSE(c[1].closed);
        CHECK(c[1].closed_but_for_border);
        CHECK(c[1].volume_mm3.value() < 0);
        CHECK(c[1].cavity_of == 0U);
        CHECK(count(show_component(p.parts, 0)) == p.mesh.triangles.size());
    }

    TEST_CASE("a body that fills most of the volume is no cavity, but pockets in it are") {
        // Outside are the corner beyond a plane, a ball within and one that a face of x cuts.
        for (const int face : {0, 23}) {
            CAPTURE(face);
            const Volume volume =
                make_volume({24, 20, 18}, Scalar::float32, [&](int x, int y, int z) {
                    const glm::dvec3 p(x, y, z);
                    const double plane = (x + y + z - 14) / 1.8;
                    return std::min({plane, glm::distance(p, glm::dvec3(12, 14, 9)) - 3,
                                     glm::distance(p, glm::dvec3(face, 15, 14)) - 2});
                });
            const Parts p = parts_of(volume, 0);
            const auto& c = p.parts.components;
            REQUIRE(c.size() == 3);
            CHECK_FALSE(c[0].closed);
            CHECK(c[0].volume_mm3.value() < 0);
            CHECK_FALSE(c[0].cavity);
            for (const std::size_t i : {1U, 2U}) {
                CAPTURE(i);
                CHECK(c[i].volume_mm3.value() < 0);
                CHECK(c[i].cavity);
                CHECK(c[i].cavity_of == 0U);
            }
            CHECK(host::largest_component(p.parts) == 0);
        }
    }

    TEST_CASE("an open component of the outside alone is no cavity") {
        const Volume volume = make_volume({20, 16, 14}, Scalar::float32, [](int x, int y, int z) {
            return glm::distance(glm::dvec3(x, y, z), glm::dvec3(19, 15, 13)) - 6;
        });
        const Parts p = parts_of(volume, 0);
        REQUIRE(p.parts.components.size() == 1);
        CHECK(p.parts.components[0].volume_mm3.value() < 0);
        CHECK_FALSE(p.parts.components[0].cavity);
    }
}
