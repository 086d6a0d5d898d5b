// Tests a surface's certificate against formulas, planted defects and an independent checker.
#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <numbers>

#include "tests/gp_firmware/surface/mesh_check.hpp"
#include "tests/host/surface/surface_support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using host::Certificate;
using host::certify;
using host::DefectKind;
using host::WeldedMesh;
using test::certify_volume;
using test::extract_slabs;
using test::gather;
using test::grid_of;
using test::make_volume;
using test::messages_of;
using test::one_voxel;
using test::padded;
using test::placed_volume;
using test::random_volume;
using test::seed_or;
using test::Size;
using test::Slabs;
using test::sums_of;
using test::Volume;

namespace {

constexpr double pi = std::numbers::pi;

/// Numbers that the tests' checker of GPs' slabs counts in its own way, with maps and sorting.
void check_against_checker(const Volume& volume, double isovalue, CaseRule rule) {
    const Slabs slabs = extract_slabs(volume, isovalue, rule);
    const auto expected = test::certify(slabs, volume.shape);
    const auto found =
        certify(gather(messages_of(slabs), grid_of(volume.shape)), grid_of(volume.shape));
    const auto same = [](std::int64_t a, std::size_t b) {
        return a == static_cast<std::int64_t>(b);
    };
    CHECK(same(found.vertices, expected.vertices));
    CHECK(same(found.edges, expected.edges));
    CHECK(same(found.triangles, expected.triangles));
    CHECK(same(found.border_edges, expected.border_edges));
    CHECK(same(found.count(DefectKind::open_edge), expected.hole_edges));
    CHECK(same(found.count(DefectKind::overfull_edge), expected.nonmanifold_edges));
    CHECK(same(found.count(DefectKind::misoriented_edge), expected.misoriented_edges));
    CHECK(same(found.count(DefectKind::pinched_vertex), expected.nonmanifold_vertices));
    CHECK(found.area_mm2 == doctest::Approx(expected.area_mm2).epsilon(1e-9));
    if (rule == CaseRule::watertight)
        CHECK(std::abs(found.volume_mm3 - expected.volume_mm3) < 1e-4);
    // Triangles that only touch at a vertex are apart here, together there.
    if (expected.nonmanifold_vertices == 0) CHECK(same(found.components, expected.components));
}

/// Faces between two cells that the 1987 table decides differently: both diagonals' corners differ,
/// and one cell has more than four inside corners, the other has not.
std::int64_t faces_of_two_minds(const Volume& volume, double isovalue) {
    const auto& shape = volume.shape;
    const auto inside = [&](glm::ivec3 p) {
        const std::size_t at = static_cast<std::size_t>((p.z * shape.ny + p.y) * shape.nx + p.x);
        double value = 0;
        gp::with_scalar(shape.type, [&]<class T>(T) { value = gp::typed<T>(volume.values)[at]; });
        return value >= isovalue;
    };
    const auto crowded = [&](glm::ivec3 cell) {
        int count = 0;
        for (int c = 0; c < 8; ++c)
            count += inside(cell + glm::ivec3(c & 1, c >> 1 & 1, c >> 2)) ? 1 : 0;
        return count > 4;
    };
    std::int64_t faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
        glm::ivec3 n(0), u(0), v(0);
        n[axis] = u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
        for (int z = n.z; z + 1 < shape.nz; ++z)
            for (int y = n.y; y + 1 < shape.ny; ++y)
                for (int x = n.x; x + 1 < shape.nx; ++x) {
                    const glm::ivec3 p(x, y, z);
                    const bool a = inside(p), b = inside(p + u), c = inside(p + u + v),
                               d = inside(p + v);
                    if (a == c && b == d && a != b && crowded(p) != crowded(p - n)) ++faces;
                }
    }
    return faces;
}

}  // namespace

TEST_SUITE("host/surface/certificate") {
    TEST_CASE("a sphere is closed, of genus 0, with its area, volume and bounds") {
        const double radius_mm = 20;
        const double c = std::cos(0.4), s = std::sin(0.4);
        const glm::dmat3 grids[] = {{0.9, 0, 0, 0, 1.1, 0, 0, 0, 2.1},
                                    {-0.9, 0, 0, 0, 1.1, 0, 0, 0, 2.1},
                                    {c, s, 0, -s, c, 0, 0.3, 0.5, 1.9}};
        for (const glm::dmat3& steps : grids) {
            const Volume volume = placed_volume({60, 52, 30}, steps,
                                                [](glm::dvec3 p) { return 100 - glm::length(p); });
            const Certificate found = certify_volume(volume, 100 - radius_mm);
            CHECK(found.closed());
            CHECK(found.good());
            CHECK(found.components == 1);
            CHECK(found.euler() == 2);
            CHECK(found.genus() == 0);
            CHECK(found.area_mm2 == doctest::Approx(4 * pi * radius_mm * radius_mm).epsilon(0.01));
            CHECK(found.volume_mm3 ==
                  doctest::Approx(4 * pi / 3 * std::pow(radius_mm, 3)).epsilon(0.01));
            for (int axis = 0; axis < 3; ++axis) {
                CHECK(found.bounds_mm.low[axis] == doctest::Approx(-radius_mm).epsilon(0.01));
                CHECK(found.bounds_mm.high[axis] == doctest::Approx(radius_mm).epsilon(0.01));
            }
        }
    }

    TEST_CASE("a torus has genus 1, two tori together 2, with their area and volume") {
        const double ring_mm = 20, tube_mm = 7;
        const auto torus = [&](glm::dvec3 p) {
            return 100 - std::hypot(std::hypot(p.x, p.y) - ring_mm, p.z);
        };
        const Certificate one =
            certify_volume(placed_volume({64, 64, 24}, glm::dmat3(1.0), torus), 100 - tube_mm);
        CHECK(one.closed());
        CHECK(one.euler() == 0);
        CHECK(one.genus() == 1);
        CHECK(one.area_mm2 == doctest::Approx(4 * pi * pi * ring_mm * tube_mm).epsilon(0.01));
        CHECK(one.volume_mm3 ==
              doctest::Approx(2 * pi * pi * ring_mm * tube_mm * tube_mm).epsilon(0.01));
        const Certificate two =
            certify_volume(placed_volume({64, 64, 52}, glm::dmat3(1.0),
                                         [&](glm::dvec3 p) {
                                             return std::max(torus(p - glm::dvec3(0, 0, 11.5)),
                                                             torus(p + glm::dvec3(0, 0, 12.5)));
                                         }),
                           100 - tube_mm);
        CHECK(two.components == 2);
        CHECK(two.genus() == 2);
    }

    TEST_CASE("a ball cut by the volume's faces has the volume of what lies within") {
        // Centered on a face, an edge or a corner: a half, a quarter, an eighth; and its
        // complement.
        const Size size{30, 26, 22};
        const glm::dvec3 last(size.nx - 1, size.ny - 1, size.nz - 1);
        const double radius = 9, whole = 4 * pi / 3 * radius * radius * radius;
        const double box = last.x * last.y * last.z;
        for (int place = 0; place < 27; ++place) {
            const glm::dvec3 relative(place % 3 / 2.0, place / 3 % 3 / 2.0, place / 9 / 2.0);
            double part = 1;
            for (int axis = 0; axis < 3; ++axis) part *= relative[axis] == 0.5 ? 1 : 0.5;
            for (const double side : {1.0, -1.0}) {
                for (const double x_step : {1.0, -1.0}) {
                    Volume volume = make_volume(size, Scalar::float32, [&](int x, int y, int z) {
                        return side *
                               (radius - glm::distance(glm::dvec3(x, y, z), relative * last));
                    });
                    volume.shape.voxel_to_patient[0][0] = x_step;
                    const Slabs slabs = extract_slabs(volume, 0);
                    const host::VolumeGrid grid = grid_of(volume.shape);
                    const Certificate found = certify(gather(messages_of(slabs), grid), grid);
                    CAPTURE(place);
                    CAPTURE(side);
                    CHECK(found.good());
                    CHECK(found.closed() == (part == 1));
                    const double ball = side > 0 ? found.volume_mm3 : box - found.volume_mm3;
                    CHECK(ball == doctest::Approx(part * whole).epsilon(0.02));
                    CHECK(found.volume_mm3 ==
                          doctest::Approx(sums_of(slabs).volume_mm3).epsilon(1e-7));
                }
            }
        }
    }

    TEST_CASE("between uneven slices, volumes and bounds are those of the slices' places") {
        const std::vector<double> places = {0, 1, 2.5, 3, 7, 7.5};
        const auto shaped = [&](auto field) {
            Volume volume = make_volume({7, 6, 6}, Scalar::float32, [&](int x, int y, int z) {
                return field(glm::dvec3(x, y, places[static_cast<std::size_t>(z)]));
            });
            volume.shape.slice_places = places;
            volume.shape.voxel_to_patient[2][2] = 2;
            return volume;
        };
        for (const double cut : {0.25, 2.75, 6.0, 7.25}) {
            const Certificate above =
                certify_volume(shaped([&](glm::dvec3 p) { return p.z - cut; }), 0);
            CHECK(above.good());
            CHECK(above.volume_mm3 == doctest::Approx(6 * 5 * 2 * (7.5 - cut)));
            CHECK(above.area_mm2 == doctest::Approx(6 * 5));
            CHECK(above.bounds_mm.low.z == doctest::Approx(2 * cut));
            const Certificate below =
                certify_volume(shaped([&](glm::dvec3 p) { return cut - p.z; }), 0);
            CHECK(below.volume_mm3 == doctest::Approx(6 * 5 * 2 * cut));
        }
        // A slanted half, whose border runs across the last x face and its rim.
        const Certificate slanted = certify_volume(
            shaped([&](glm::dvec3 p) { return p.y / 5 + p.z / 7.5 - 1 + 1e-6 * p.x; }), 0);
        CHECK(slanted.good());
        CHECK(slanted.volume_mm3 == doctest::Approx(6 * 5 * 2 * 7.5 / 2).epsilon(1e-4));
    }

    TEST_CASE("a voxel that is the isovalue is eight triangles of no area and no volume") {
        const Certificate found = certify_volume(one_voxel(4), 4);
        CHECK(found.closed());
        CHECK(found.good());
        CHECK(found.triangles == 8);
        CHECK(found.degenerate == 8);
        CHECK(found.slivers == 0);
        CHECK(found.genus() == 0);
        CHECK(found.area_mm2 == 0);
        CHECK(std::abs(found.volume_mm3) < 1e-12);
    }

    TEST_CASE("next to no volume is not taken for the whole box, nor the box for nothing") {
        // A voxel a hair above the isovalue: rounding decides the sign of the tiny volume.
        const unsigned seed = seed_or(45U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::size_t wrong = 0;
        for (int i = 0; i < 300; ++i) {
            const glm::ivec3 at(1 + random() % 28, 1 + random() % 8, 1 + random() % 6);
            const double hair = std::pow(0.1, double(5 + random() % 4));
            for (const double side : {1.0, -1.0}) {
                const Volume volume =
                    make_volume({30, 10, 8}, Scalar::float32, [&](int x, int y, int z) {
                        return side * (glm::ivec3(x, y, z) == at ? hair : -1.0);
                    });
                const double volume_mm3 = certify_volume(volume, 0).volume_mm3;
                const double expected_mm3 = side > 0 ? 0 : 29 * 9 * 7;
                wrong += std::abs(volume_mm3 - expected_mm3) < 1e-6 ? 0 : 1;
            }
        }
        CHECK(wrong == 0);
    }

    TEST_CASE("slivers are triangles with an angle below 1 degree, in millimeters") {
        host::VolumeGrid grid{9, 9, 9, glm::dmat4(1.0), {}};
        WeldedMesh mesh;
        mesh.keys = {400, 401, 402};
        mesh.normals.assign(3, {0, 0, 1});
        mesh.triangles = {{0, 1, 2}};
        const auto slivers = [&](double angle_deg, double y_step_mm) {
            grid.voxel_to_patient[1][1] = y_step_mm;
            const double tangent = std::tan(angle_deg * pi / 180) / y_step_mm;
            mesh.p_grid = {{1, 1, 1}, {2, 1, 1}, {2, 1 + static_cast<float>(tangent), 1}};
            return certify(mesh, grid).slivers;
        };
        for (const double y_step_mm : {1.0, 0.2, 7.0}) {
            CHECK(slivers(0.99, y_step_mm) == 1);
            CHECK(slivers(1.01, y_step_mm) == 0);
        }
    }

    TEST_CASE("10,000 random 4x4x4 fields with the isovalue on a voxel's value are watertight") {
        const unsigned seed = seed_or(41U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        std::size_t bad = 0, open = 0, bad_genus = 0, cut = 0;
        for (int i = 0; i < 10000; ++i) {
            const auto levels = static_cast<unsigned>(2 + random() % 6);
            const Volume volume = random_volume({4, 4, 4}, Scalar::int16, levels, random);
            const double isovalue = double(random() % levels);
            const Certificate in_air = certify_volume(padded(volume, -1), isovalue);
            bad += in_air.good() || in_air.triangles == 0 ? 0 : 1;
            open += in_air.closed() || in_air.triangles == 0 ? 0 : 1;
            bad_genus += in_air.genus().value_or(0) >= 0 && in_air.euler() % 2 == 0 ? 0 : 1;
            const Certificate bare = certify_volume(volume, isovalue);
            bad += bare.good() || bare.triangles == 0 ? 0 : 1;
            cut += bare.closed() ? 0 : 1;
        }
        CHECK(bad == 0);
        CHECK(open == 0);
        CHECK(bad_genus == 0);
        CHECK(cut > 5000);
    }

    TEST_CASE("noise has the counts of another checker, with and without holes") {
        const unsigned seed = seed_or(42U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        for (const auto type : {Scalar::uint8, Scalar::int16, Scalar::float32})
            for (const double isovalue : {3.0, 4.5})
                for (const auto rule :
                     {CaseRule::watertight, CaseRule::asymptotic, CaseRule::lorensen1987}) {
                    const Volume volume = random_volume({15, 11, 13}, type, 9, random);
                    check_against_checker(volume, isovalue, rule);
                    check_against_checker(padded(volume, 0), isovalue, rule);
                }
    }

    TEST_CASE("holes are the faces that two cells decide differently, also where these touch") {
        const unsigned seed = seed_or(43U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        for (int i = 0; i < 20; ++i) {
            const Volume volume = random_volume({8, 7, 6}, Scalar::uint8, 2, random);
            const std::int64_t faces = faces_of_two_minds(volume, 1);
            REQUIRE(faces > 5);
            const Certificate found = certify_volume(volume, 1, CaseRule::lorensen1987);
            CHECK(found.holes == faces);
            CHECK(found.count(DefectKind::open_edge) == 4 * faces);
        }
    }
}
