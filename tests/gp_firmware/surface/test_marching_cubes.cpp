#include <doctest/doctest.h>

#include <set>

#include "gp_firmware/surface/marching_cubes.hpp"
#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::certify;
using pxpl5::test::extract_all;
using pxpl5::test::Gp;
using pxpl5::test::make_volume;
using pxpl5::test::Volume;

namespace {

Volume noise(pxpl5::test::Size size, Scalar type, unsigned levels, unsigned seed = 3) {
    std::mt19937 random(seed);
    return make_volume(size, type, [&](int, int, int) { return double(random() % levels); });
}

/// One voxel of `peak` in the middle of 3x3x3 zeros.
Volume single_voxel(double peak) {
    return make_volume({3, 3, 3}, Scalar::int16, [&](int x, int y, int z) {
        return x == 1 && y == 1 && z == 1 ? peak : 0.0;
    });
}

bool same(const SlabMesh& a, const SlabMesh& b) {
    const auto bytes = [](const SlabMesh& m) {
        return std::string_view(reinterpret_cast<const char*>(m.vertices.data()),
                                m.vertices.size() * sizeof(Vertex));
    };
    return a.slab == b.slab && bytes(a) == bytes(b) && a.keys == b.keys && a.indices == b.indices &&
           a.counts.triangles == b.counts.triangles && a.counts.vertices == b.counts.vertices &&
           a.counts.cells_active == b.counts.cells_active &&
           a.counts.cells_ambiguous == b.counts.cells_ambiguous &&
           a.counts.rows_skipped == b.counts.rows_skipped &&
           a.counts.cells_visited == b.counts.cells_visited &&
           a.counts.edges_visited == b.counts.edges_visited &&
           a.counts.edges_crossed == b.counts.edges_crossed &&
           a.counts.area_mm2 == b.counts.area_mm2 && a.counts.volume_mm3 == b.counts.volume_mm3;
}

}  // namespace

TEST_SUITE("gp/marching_cubes") {
    TEST_CASE("a single voxel gives an octahedron with its six vertices on the voxel's edges") {
        const auto meshes = extract_all(single_voxel(4), 1);
        REQUIRE(meshes.size() == 2);
        const auto certificate = certify(meshes, single_voxel(4).shape);
        CHECK(certificate.closed());
        CHECK(certificate.vertices == 6);
        CHECK(certificate.triangles == 8);
        std::set<std::uint64_t> keys;
        const std::map<std::uint64_t, std::array<float, 3>> expected = {
            {4 * 12 + 0, {0.25F, 1, 1}}, {4 * 13 + 0, {1.75F, 1, 1}}, {4 * 10 + 1, {1, 0.25F, 1}},
            {4 * 13 + 1, {1, 1.75F, 1}}, {4 * 4 + 2, {1, 1, 0.25F}},  {4 * 13 + 2, {1, 1, 1.75F}}};
        for (const SlabMesh& mesh : meshes)
            for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
                REQUIRE(expected.contains(mesh.keys[i]));
                const auto& p = expected.at(mesh.keys[i]);
                CHECK(mesh.vertices[i].p_voxel == glm::vec3(p[0], p[1], p[2]));
                keys.insert(mesh.keys[i]);
            }
        CHECK(keys.size() == 6);
        // An octahedron with half-diagonal h has 8 faces of sqrt(3)/2 h^2 and volume 4/3 h^3.
        CHECK(certificate.volume_mm3 == doctest::Approx(4.0 / 3 * 0.75 * 0.75 * 0.75));
        CHECK(certificate.area_mm2 == doctest::Approx(8 * std::sqrt(3.0) / 2 * 0.75 * 0.75));
    }

    TEST_CASE("a voxel is inside if it equals the isovalue") {
        CHECK(certify(extract_all(single_voxel(4), 4), single_voxel(4).shape).triangles == 8);
        CHECK(certify(extract_all(single_voxel(4), 4.001), single_voxel(4).shape).triangles == 0);
        const auto all = extract_all(single_voxel(4), 0);
        CHECK(certify(all, single_voxel(4).shape).triangles == 0);
    }

    TEST_CASE("normals point away from the inside along the gradient, in patient axes") {
        Volume volume = make_volume({6, 6, 6}, Scalar::int16,
                                    [](int x, int y, int) { return 1000.0 - 40 * x - 30 * y; });
        volume.shape.voxel_to_patient = glm::dmat4(1.0);
        volume.shape.voxel_to_patient[1][1] = 3;  // 3 mm per row: 10 per mm.
        const double steep = 40, gentle = 10, length = std::hypot(steep, gentle);
        std::size_t count = 0;
        for (const SlabMesh& mesh : extract_all(volume, 870.5))
            for (const Vertex& vertex : mesh.vertices) {
                ++count;
                CHECK(vertex.normal[0] == doctest::Approx(steep / length * 32767).epsilon(1e-4));
                CHECK(vertex.normal[1] == doctest::Approx(gentle / length * 32767).epsilon(1e-4));
                CHECK(vertex.normal[2] == 0);
            }
        CHECK(count > 10);
    }

    TEST_CASE("where gradients cancel out, the normal leaves the inside along the edge") {
        // Zeros with a plane of ones: the differences across the plane are 0 in its voxels, and
        // between a plane and its mirror image.
        const Volume volume = make_volume({8, 4, 4}, Scalar::uint8,
                                          [](int x, int, int) { return x % 2 == 0 ? 0.0 : 8.0; });
        std::size_t inner = 0;
        for (const SlabMesh& mesh : extract_all(volume, 2))
            for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
                const auto x = static_cast<int>(mesh.keys[i] / 4 % 8);
                if (x == 0 || x == 6) continue;  // One-sided differences are not 0.
                ++inner;
                const int outward = x % 2 == 0 ? -1 : 1;
                CHECK(
                    mesh.vertices[i].normal ==
                    std::array<std::int16_t, 3>{static_cast<std::int16_t>(outward * 32767), 0, 0});
            }
        CHECK(inner > 10);
    }

    TEST_CASE("an ambiguous face joins its inside corners where its saddle is inside, ties apart") {
        // Face z = 0 has `in` on one diagonal and `out` on the other; face z = 1 is outside. The
        // saddle is at or above the isovalue 0 where in * in >= out * out.
        // Joined, the surface is one sheet around both; apart, it is a cap at each corner.
        for (const bool turned : {false, true}) {
            const auto sheets = [&](double in, double out) {
                const Volume volume =
                    make_volume({2, 2, 2}, Scalar::int16, [&](int x, int y, int z) {
                        return z == 1 ? -5 : (x == y) != turned ? in : out;
                    });
                const auto meshes = extract_all(volume, 0, CaseRule::asymptotic);
                CHECK(meshes[0].counts.cells_ambiguous == 1);
                const auto components = certify(meshes, volume.shape).components;
                CHECK(meshes[0].counts.triangles == (components == 1 ? 4 : 2));
                return components;
            };
            CHECK(sheets(4, -3) == 1);
            CHECK(sheets(3, -4) == 2);
            CHECK(sheets(3, -3) == 2);
        }
    }

    TEST_CASE("any number of GPs and of slabs in a set gives the same bits") {
        for (const Scalar type : {Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32}) {
            Volume volume = noise({21, 17, 13}, type, 9);
            const auto one = extract_all(volume, 4, CaseRule::asymptotic);
            for (const int slabs_per_set : {1, 2, 5, 100}) {
                volume.shape.slabs_per_set = slabs_per_set;
                for (const int count : {1, 2, 3, 5, 36}) {
                    const auto many = extract_all(volume, 4, CaseRule::asymptotic, count);
                    for (std::size_t i = 0; i < one.size(); ++i) CHECK(same(one[i], many[i]));
                }
            }
            CHECK(certify(one, volume.shape).good());
        }
    }

    TEST_CASE("a slab extracted in pieces has the bits of one extracted at once") {
        const Volume volume = noise({70, 30, 4}, Scalar::int16, 100);
        const Gp gp(volume, {0, 1});
        const CaseTable& table = case_table(CaseRule::asymptotic);
        SlabMesh whole, pieces;
        extract_slab(gp.store, 1, 50, table, whole, true);
        const SlabExtraction extraction = begin_slab(gp.store, 1, 50, table, pieces, true);
        int count = 1;
        while (extraction(1)) ++count;
        CHECK(same(whole, pieces));
        CHECK(whole.origins == pieces.origins);
        CHECK(count == 29);  // Rows of cells, each with a triangle.
        CHECK(whole.counts.area_mm2 == pieces.counts.area_mm2);
        CHECK(whole.counts.volume_mm3 == pieces.counts.volume_mm3);
    }

    TEST_CASE("measuring an isovalue counts what extraction counts, to the last bit") {
        Volume volume = noise({33, 17, 9}, Scalar::int16, 60);
        volume.shape.voxel_to_patient = glm::dmat4(glm::dmat3{-0.7, 0.1, 0, 0, 0.9, 0, 0, 0, 1.7});
        for (int z = 0; z < 9; ++z) volume.shape.slice_places.push_back(z + 0.04 * z * z);
        const Gp gp(volume, {0, 1});
        SlabMesh mesh, scratch;
        for (const auto rule : {CaseRule::watertight, CaseRule::lorensen1987, CaseRule::asymptotic})
            for (const int slab : gp.store.slabs())
                for (const double isovalue : {-1.0, 0.0, 3.5, 30.0, 58.0, 59.5, 70.0}) {
                    extract_slab(gp.store, slab, isovalue, case_table(rule), mesh);
                    const SlabCounts counts =
                        measure_slab(gp.store, slab, isovalue, case_table(rule), scratch);
                    CHECK(counts.triangles == mesh.counts.triangles);
                    CHECK(counts.vertices == mesh.counts.vertices);
                    CHECK(counts.cells_active == mesh.counts.cells_active);
                    CHECK(counts.area_mm2 == mesh.counts.area_mm2);
                    CHECK(counts.volume_mm3 == mesh.counts.volume_mm3);
                }
    }

    TEST_CASE(
        "a mesh that is used again holds nothing of the surface before, and its memory stays") {
        const Volume volume = noise({70, 30, 4}, Scalar::int16, 100);
        const Gp gp(volume, {0, 1});
        const CaseTable& table = case_table(CaseRule::asymptotic);
        SlabMesh reused, fresh;
        extract_slab(gp.store, 0, 50, table, reused);
        const Vertex* vertices = reused.vertices.data();
        const std::size_t memory_bytes = size_bytes(reused);
        for (const double isovalue : {50.0, 90.5, 200.0, 50.0}) {
            extract_slab(gp.store, 0, isovalue, table, reused);
            SlabMesh again;
            extract_slab(gp.store, 0, isovalue, table, again);
            CHECK(same(reused, again));
            CHECK(reused.vertices.data() == vertices);
            CHECK(size_bytes(reused) == memory_bytes);
        }
    }

    TEST_CASE("cells, skipped rows and owned vertices are counted as defined") {
        const Volume volume = noise({10, 9, 8}, Scalar::uint8, 5);
        const double isovalue = 2;
        const auto meshes = extract_all(volume, isovalue);
        const auto inside = [&](int x, int y, int z) {
            return double(volume.values[static_cast<std::size_t>((z * 9 + y) * 10 + x)]) >=
                   isovalue;
        };
        for (int z = 0; z < 7; ++z) {
            std::uint32_t active = 0, ambiguous = 0;
            for (int y = 0; y < 8; ++y)
                for (int x = 0; x < 9; ++x) {
                    std::uint8_t corners = 0;
                    for (int c = 0; c < 8; ++c)
                        if (inside(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)))
                            corners = static_cast<std::uint8_t>(corners | 1 << c);
                    active += corners != 0 && corners != 255 ? 1U : 0U;
                    ambiguous += case_table(CaseRule::asymptotic).ambiguous[corners] ? 1U : 0U;
                }
            const SlabCounts& counts = meshes[static_cast<std::size_t>(z)].counts;
            CHECK(counts.cells_active == active);
            CHECK(counts.cells_ambiguous == ambiguous);
            CHECK(counts.triangles == meshes[static_cast<std::size_t>(z)].indices.size() / 3);
        }
        CHECK(certify(meshes, volume.shape).owned_vertices ==
              certify(meshes, volume.shape).vertices);
    }

    TEST_CASE("rows and slabs that the surface cannot cross are skipped") {
        const Volume volume = make_volume({70, 10, 8}, Scalar::int16, [](int x, int y, int z) {
            return x > 30 && y >= 4 && y <= 5 && z == 4 ? 100.0 : 0.0;
        });
        const auto meshes = extract_all(volume, 50);
        // Only cell rows 3, 4 and 5 of slabs 3 and 4 touch a mixed row; there are 9 cell rows.
        for (const SlabMesh& mesh : meshes)
            CHECK(mesh.counts.rows_skipped == (mesh.slab == 3 || mesh.slab == 4 ? 6 : 9));
        CHECK(certify(meshes, volume.shape).good());
        CHECK(certify(meshes, volume.shape).triangles > 0);
    }

    TEST_CASE("voxels that are not numbers are outside and make no vertex that is not one") {
        std::mt19937 random(5);
        const double infinity = std::numeric_limits<double>::infinity();
        const double odd[] = {std::nan(""), infinity, -infinity};
        const Volume volume = make_volume({12, 12, 12}, Scalar::float32, [&](int, int, int) {
            return random() % 4 == 0 ? odd[random() % 3] : double(random() % 10);
        });
        const auto meshes = extract_all(pxpl5::test::padded(volume, std::nan("")), 4.5);
        const auto certificate = certify(meshes, pxpl5::test::padded(volume, std::nan("")).shape);
        CHECK_MESSAGE(certificate.closed(), certificate);
        CHECK(certificate.triangles > 1000);
        for (const SlabMesh& mesh : meshes)
            for (const Vertex& vertex : mesh.vertices) {
                for (int i = 0; i < 3; ++i) CHECK(std::isfinite(vertex.p_voxel[i]));
                CHECK((vertex.normal[0] != 0 || vertex.normal[1] != 0 || vertex.normal[2] != 0));
            }
    }

    TEST_CASE("a volume of two slices has one slab, whose surface ends at the border") {
        const Volume volume = make_volume({5, 5, 2}, Scalar::uint8, [](int x, int y, int) {
            return x == 2 && y == 2 ? 10.0 : 0.0;
        });
        const auto meshes = extract_all(volume, 5);
        REQUIRE(meshes.size() == 1);
        const auto certificate = certify(meshes, volume.shape);
        CHECK(certificate.good());
        CHECK(certificate.border_edges == 8);
        CHECK(certificate.triangles == 8);
        CHECK(certificate.area_mm2 == doctest::Approx(4 * std::sqrt(0.5)));
        CHECK(meshes[0].counts.vertices == 8);
    }

    TEST_CASE("isovalues at and beyond the volume's ends give a surface or none, never a defect") {
        const Volume volume = padded(noise({6, 6, 6}, Scalar::int16, 7), -1);
        for (const double isovalue : {-1.0, 0.0, 6.0, 6.5, -1.5, 1e9, -1e9, 1e300}) {
            const auto meshes = extract_all(volume, isovalue);
            CHECK(certify(meshes, volume.shape).closed());
            CHECK((certify(meshes, volume.shape).triangles > 0) ==
                  (isovalue > -1 && isovalue <= 6));
        }
    }

    TEST_CASE("an isovalue that is not finite is refused") {
        const Gp gp(single_voxel(4), {0, 1});
        SlabMesh mesh;
        for (const double isovalue : {std::nan(""), HUGE_VAL, -HUGE_VAL})
            CHECK_THROWS_AS(
                extract_slab(gp.store, 0, isovalue, case_table(CaseRule::asymptotic), mesh),
                std::invalid_argument);
    }
}
