// Components at many isovalues, against those of extracted meshes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/surface/atlas/isovalue_components.hpp"
#include "host/surface/components.hpp"
#include "tests/host/surface/surface_support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;
using host::count_components;

namespace {

std::size_t extracted_components(const Volume& volume, double isovalue) {
    const auto grid = grid_of(volume.shape);
    return host::find_components(mesh_of(volume, isovalue), grid).components.size();
}

/// Isovalues at which the sweep and extraction disagree.
std::size_t disagreements(const Volume& volume, const std::vector<double>& isovalues) {
    const auto counts = count_components(for_host(volume), isovalues);
    REQUIRE(counts.size() == isovalues.size());
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < isovalues.size(); ++i)
        wrong += counts[i].surface() == extracted_components(volume, isovalues[i]) ? 0 : 1;
    return wrong;
}

}  // namespace

TEST_SUITE("host/surface/isovalue_components") {
    TEST_CASE(
        "3,000 random fields have the components of their extracted surfaces, ties included") {
        // With few levels most voxels tie with neighbors and isovalues; fields reach the border.
        const unsigned seed = seed_or(61U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::size_t wrong = 0;
        for (int i = 0; i < 3000; ++i) {
            const Size size{int(2 + random() % 5), int(2 + random() % 5), int(2 + random() % 5)};
            const auto levels = static_cast<unsigned>(2 + random() % 7);
            const auto type = static_cast<Scalar>(random() % 4);
            const Volume volume = random_volume(size, type, levels, random);
            std::vector<double> isovalues;
            for (unsigned level = 0; level <= levels; ++level)
                for (const double part : {0.0, 0.5})
                    if (random() % 2 == 0) isovalues.push_back(level + part);
            wrong += disagreements(volume, isovalues);
        }
        CHECK(wrong == 0);
    }

    TEST_CASE("sparse and dense fields, where diagonals decide, have them too") {
        const unsigned seed = seed_or(62U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::size_t wrong = 0;
        for (int i = 0; i < 300; ++i) {
            const auto of_hundred = 5 + random() % 90;
            const Volume volume = make_volume({9, 8, 7}, Scalar::int16, [&](int, int, int) {
                return random() % 100 < of_hundred ? 1.0 : 0.0;
            });
            wrong += disagreements(volume, {1});
        }
        CHECK(wrong == 0);
    }

    TEST_CASE("smooth noise over many isovalues has them too") {
        const unsigned seed = seed_or(63U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        Volume volume = random_volume({14, 13, 12}, Scalar::float32, 1000, random);
        std::vector<double> isovalues;
        for (int i = 0; i < 100; ++i) isovalues.push_back(10 * i);
        CHECK(disagreements(volume, isovalues) == 0);
    }

    TEST_CASE("diagonals join outside voxels in a face, not inside ones, and not through a cell") {
        // Values at the corners of a cell; corner c is at (c & 1, c >> 1 & 1, c >> 2).
        const auto counts = [](unsigned inside) {
            const Volume volume = make_volume({2, 2, 2}, Scalar::uint8, [&](int x, int y, int z) {
                return (inside >> (x + 2 * y + 4 * z) & 1) != 0 ? 1.0 : 0.0;
            });
            const std::vector<double> isovalues{1};
            return count_components(for_host(volume), isovalues)[0];
        };
        const unsigned face = 1 << 0 | 1 << 3, body = 1 << 0 | 1 << 7;
        CHECK(counts(face).inside == 2);
        CHECK(counts(face).outside == 1);
        CHECK(counts(body).inside == 2);
        CHECK(counts(255 - face).outside == 1);
        CHECK(counts(255 - face).surface() == 1);
        CHECK(counts(255 - body).outside == 2);
        CHECK(counts(255 - body).surface() == 2);
        CHECK(counts(0).surface() == 0);
        CHECK(counts(255).surface() == 0);
        CHECK(counts(0).inside == 0);
        CHECK(counts(255).outside == 0);
    }

    TEST_CASE("values that are no numbers are outside, infinite ones at their ends") {
        const unsigned seed = seed_or(64U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        const double special[] = {std::nan(""), INFINITY, -INFINITY};
        std::size_t wrong = 0;
        for (int i = 0; i < 200; ++i) {
            const Volume volume = make_volume({4, 5, 4}, Scalar::float32, [&](int, int, int) {
                return random() % 4 == 0 ? special[random() % 3] : double(random() % 5);
            });
            wrong += disagreements(volume, {-1, 0, 1, 2.5, 4, 5});
        }
        CHECK(wrong == 0);
    }

    TEST_CASE("equal isovalues have equal counts, isovalues beyond all values none") {
        std::mt19937 random(65);
        const Volume volume = random_volume({8, 8, 8}, Scalar::uint16, 7, random);
        const auto counts =
            count_components(for_host(volume), std::vector<double>{-5, 0, 3, 3, 3, 100});
        CHECK(counts[2].surface() == counts[3].surface());
        CHECK(counts[2].surface() == counts[4].surface());
        CHECK(counts[2].surface() == extracted_components(volume, 3));
        for (const std::size_t i : {0U, 1U}) {
            CHECK(counts[i].inside == 1);
            CHECK(counts[i].outside == 0);
        }
        CHECK(counts[5].inside == 0);
        CHECK(counts[5].outside == 1);
        CHECK(count_components(for_host(volume), {}).empty());
    }

    TEST_CASE("a single slice has no cells, and is refused") {
        host::Volume volume =
            for_host(make_volume({3, 4, 2}, Scalar::uint8, [](int, int, int) { return 1; }));
        volume.nz = 1;
        volume.values.resize(volume.values.size() / 2);
        CHECK_THROWS_WITH_AS(count_components(volume, std::vector<double>{1}),
                             "counting components: 3x4x1 voxels have no cell, which takes 2 along "
                             "each axis",
                             host::RequestError);
    }
}
