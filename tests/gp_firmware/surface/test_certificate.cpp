// Random volumes, isovalues on voxel values: the surface is closed, manifold and oriented.
#include <doctest/doctest.h>

#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/gp_firmware/test_volume.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Certificate;
using pxpl5::test::certify;
using pxpl5::test::extract_all;
using pxpl5::test::make_volume;
using pxpl5::test::seed_or;
using pxpl5::test::Volume;

namespace {

Certificate certify_padded(const Volume& volume, double isovalue, CaseRule rule) {
    const Volume in_air = pxpl5::test::padded(volume, -1);
    return certify(extract_all(in_air, isovalue, rule), in_air.shape);
}

template <class Random>
Volume random_volume(pxpl5::test::Size size, Scalar type, unsigned levels, Random& random) {
    return make_volume(size, type, [&](int, int, int) { return double(random() % levels); });
}

}  // namespace

TEST_SUITE("gp/certificate") {
    TEST_CASE("random 4x4x4 fields with the isovalue on a voxel's value are closed manifolds") {
        const unsigned seed = seed_or(2024U);
        std::mt19937 random(seed);
        for (int i = 0; i < 3000; ++i) {
            const auto levels = static_cast<unsigned>(2 + random() % 6);
            const auto volume = random_volume({4, 4, 4}, Scalar::int16, levels, random);
            const double isovalue = double(random() % levels);
            const auto certificate = certify_padded(volume, isovalue, CaseRule::asymptotic);
            INFO("seed ", seed, ", field ", i, ", isovalue ", isovalue);
            CHECK_MESSAGE(certificate.closed(), certificate);
        }
    }

    TEST_CASE("noise is a closed manifold, at isovalues on and between voxel values") {
        const unsigned seed = seed_or(7U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        const auto volume = random_volume({24, 20, 22}, Scalar::uint16, 11, random);
        for (const double isovalue : {3.0, 5.0, 5.5, 8.25}) {
            for (const CaseRule rule : {CaseRule::asymptotic, CaseRule::watertight}) {
                const auto certificate = certify_padded(volume, isovalue, rule);
                CHECK_MESSAGE(certificate.closed(), certificate);
                CHECK(certificate.triangles > 10000);
            }
        }
        // Unpadded, it ends at the volume's border and nowhere else.
        const auto open = certify(extract_all(volume, 5), volume.shape);
        CHECK_MESSAGE(open.good(), open);
        CHECK(open.border_edges > 100);
    }

    TEST_CASE("every case of two neighbors is met: all corners of 3x2x2 voxels, all values") {
        // All 4096 sides of 12 voxels, with values that make every face decision occur.
        const unsigned seed = seed_or(99U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::size_t bad = 0;
        for (unsigned sides = 0; sides < 4096; ++sides) {
            const auto volume = make_volume({3, 2, 2}, Scalar::int16, [&](int x, int y, int z) {
                const double depth = double(random() % 9);
                return (sides >> (x + 3 * y + 6 * z) & 1) != 0 ? 20 + depth : 19 - depth;
            });
            bad += certify_padded(volume, 20, CaseRule::asymptotic).closed() ? 0 : 1;
        }
        CHECK(bad == 0);
    }

    TEST_CASE("the 1987 table leaves holes in a random field, and the checker sees them") {
        std::mt19937 random(1987);
        const auto volume = random_volume({12, 12, 12}, Scalar::uint8, 10, random);
        const auto certificate = certify_padded(volume, 5, CaseRule::lorensen1987);
        CHECK(certificate.hole_edges > 0);
        CHECK(certify_padded(volume, 5, CaseRule::asymptotic).hole_edges == 0);
    }

    TEST_CASE("the checker sees each kind of defect") {
        const auto volume = make_volume({3, 3, 3}, Scalar::int16, [](int x, int y, int z) {
            return x == 1 && y == 1 && z == 1 ? 4.0 : 0.0;
        });
        const auto good = extract_all(volume, 1);
        REQUIRE(certify(good, volume.shape).closed());
        auto bad = good;
        bad[0].indices.resize(bad[0].indices.size() - 3);
        CHECK(certify(bad, volume.shape).hole_edges == 3);
        bad = good;
        std::swap(bad[0].indices[0], bad[0].indices[1]);
        CHECK(certify(bad, volume.shape).misoriented_edges == 3);
        bad = good;
        bad[0].indices.insert(bad[0].indices.end(), good[0].indices.begin(),
                              good[0].indices.begin() + 3);
        CHECK(certify(bad, volume.shape).nonmanifold_edges == 3);
        bad = good;
        bad[1].vertices[0].p_voxel.x = std::nextafter(bad[1].vertices[0].p_voxel.x, 9.0F);
        CHECK(certify(bad, volume.shape).weld_mismatches == 1);
        bad = good;
        bad[0].indices[0] = 1000;
        CHECK(certify(bad, volume.shape).bad_indices == 1);
        bad = good;
        ++bad[0].counts.vertices;
        CHECK_FALSE(certify(bad, volume.shape).good());
        // Two octahedra joined at a tip.
        const auto pair = make_volume({5, 3, 3}, Scalar::int16, [](int x, int y, int z) {
            return x % 2 == 1 && y == 1 && z == 1 ? 4.0 : 0.0;
        });
        bad = extract_all(pair, 1);
        REQUIRE(certify(bad, pair.shape).components == 2);
        for (SlabMesh& mesh : bad)
            for (std::uint64_t& key : mesh.keys)
                if (key == 4 * 22) key = 4 * 21;  // Vertices at x = 2.25 and x = 1.75.
        CHECK(certify(bad, pair.shape).nonmanifold_vertices == 1);
    }
}
