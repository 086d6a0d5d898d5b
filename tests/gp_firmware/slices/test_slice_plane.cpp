// Tests the triangles of slice planes against the voxels that they show.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "gp_firmware/geometry/transform.hpp"
#include "gp_firmware/slices/slice_plane.hpp"
#include "tests/gp_firmware/test_volume.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Gp;
using pxpl5::test::make_volume;
using pxpl5::test::Volume;

namespace {

constexpr int nx = 7, ny = 5, nz = 6;

double field(int x, int y, int z) {
    return 100 * x + 10 * y + z;
}

Volume counted(Scalar type = Scalar::int16) {
    return make_volume({nx, ny, nz}, type, field);
}

using Position = std::tuple<float, float, float>;

/// The plane's corners of all GPs: the normal's z at each position.
struct Corners {
    std::map<Position, int> grays;
    std::size_t triangles = 0;
    bool meets = true;  ///< Corners of two slabs at one place have one gray value.
};

Corners corners_of(const Volume& volume, const SlicePlane& plane, int gp_count = 1) {
    Corners corners;
    for (int i = 0; i < gp_count; ++i) {
        const Gp gp(volume, {i, gp_count});
        SlicePlanes planes;
        for (const int slab : gp.store.slabs()) {
            std::size_t triangles = 0;
            const int pieces = plane_pieces(plane, volume.shape, slab);
            for (int piece = 0; piece < pieces; ++piece) {
                const SlabMesh& mesh = planes.mesh(gp.store, plane, slab, piece, false);
                CHECK(mesh.slab == slab);
                CHECK(mesh.indices.size() / 3 <= 50'000);
                triangles += mesh.indices.size() / 3;
                for (const Vertex& v : mesh.vertices) {
                    CHECK(v.normal[0] == 0);
                    CHECK(v.normal[1] == 0);
                    const Position p{v.p_voxel.x, v.p_voxel.y, v.p_voxel.z};
                    const auto [at, is_new] = corners.grays.try_emplace(p, v.normal[2]);
                    corners.meets = corners.meets && at->second == v.normal[2];
                }
            }
            CHECK(triangles == plane_triangles(plane, volume.shape, slab));
            corners.triangles += triangles;
        }
    }
    return corners;
}

/// The gray value that a picture shows of a normal: the upper 8 bits of 9.
int shown(int normal) {
    return static_cast<int>(std::lround(normal * isa::region::normal_unit / double{normal_one})) >>
           1;
}

}  // namespace

TEST_SUITE("gp/slice_plane") {
    TEST_CASE("a plane has each of its voxels once, with the rounded gray value") {
        const Volume volume = counted();
        for (int axis = 0; axis < 3; ++axis) {
            for (const int index : {0, 2, 4}) {
                CAPTURE(axis);
                CAPTURE(index);
                const SlicePlane plane{axis, index, 50, 550};
                const Corners corners = corners_of(volume, plane);
                const std::array sizes{nx, ny, nz};
                std::size_t wanted = 1;
                for (int other = 0; other < 3; ++other) {
                    wanted *=
                        other == axis
                            ? 1
                            : static_cast<std::size_t>(sizes[static_cast<std::size_t>(other)]);
                }
                CHECK(corners.grays.size() == wanted);
                CHECK(corners.meets);
                for (const auto& [p, normal] : corners.grays) {
                    const auto& [x, y, z] = p;
                    CHECK(std::array{x, y, z}[static_cast<std::size_t>(axis)] ==
                          static_cast<float>(index));
                    const double value =
                        field(static_cast<int>(x), static_cast<int>(y), static_cast<int>(z));
                    const double share = std::clamp((value - 50) / 500, 0.0, 1.0);
                    CHECK(shown(normal) == static_cast<int>(std::floor(255 * share + 0.5)));
                }
            }
        }
    }

    TEST_CASE("the last slice belongs to the last slab, every other one to the slab above") {
        const VolumeShape shape = counted().shape;
        constexpr std::uint32_t whole = 2 * (nx - 1) * (ny - 1);
        for (int slab = 0; slab < shape.slab_count(); ++slab) {
            CHECK(plane_triangles({2, 3, 0, 1}, shape, slab) == (slab == 3 ? whole : 0));
            CHECK(plane_triangles({2, nz - 1, 0, 1}, shape, slab) == (slab == nz - 2 ? whole : 0));
            CHECK(plane_triangles({0, 3, 0, 1}, shape, slab) == 2 * (ny - 1));
            CHECK(plane_triangles({1, 3, 0, 1}, shape, slab) == 2 * (nx - 1));
        }
    }

    TEST_CASE("any number of GPs has the same corners and triangles") {
        const Volume volume = counted();
        for (int axis = 0; axis < 3; ++axis) {
            const SlicePlane plane{axis, 3, 0, 700};
            const Corners one = corners_of(volume, plane);
            CHECK(one.triangles > 0);
            for (const int gp_count : {2, 3, 7}) {
                const Corners more = corners_of(volume, plane, gp_count);
                CHECK(more.grays == one.grays);
                CHECK(more.triangles == one.triangles);
            }
        }
    }

    TEST_CASE("every type of voxels has the same gray values") {
        const SlicePlane plane{1, 2, 0, 650};
        const Corners wanted = corners_of(counted(), plane);
        for (const Scalar type : {Scalar::uint16, Scalar::float32}) {
            CHECK(corners_of(counted(type), plane).grays == wanted.grays);
        }
    }

    TEST_CASE("values beyond the window are black and white, NaN is black") {
        const std::array<double, 5> values{-1e30, 9.999, 10, 20, 1e30};
        const Volume volume = make_volume({6, 2, 2}, Scalar::float32, [&](int x, int, int) {
            return x == 5 ? std::numeric_limits<double>::quiet_NaN()
                          : values[static_cast<std::size_t>(x)];
        });
        const Corners corners = corners_of(volume, {2, 0, 10, 20});
        const std::array<int, 6> wanted{0, 0, 0, 255, 255, 0};
        for (const auto& [p, normal] : corners.grays) {
            CHECK(shown(normal) == wanted[static_cast<std::size_t>(std::get<0>(p))]);
        }
    }

    TEST_CASE("corners lie where unevenly spaced slices lie") {
        Volume volume = counted();
        volume.shape.slice_places = {0, 1, 2.5, 3, 4, 5};
        std::set<float> places;
        for (const auto& [p, normal] : corners_of(volume, {0, 1, 0, 1}).grays) {
            places.insert(std::get<2>(p));
        }
        CHECK(places == std::set<float>{0, 1, 2.5, 3, 4, 5});
        CHECK(std::get<2>(corners_of(volume, {2, 2, 0, 1}).grays.begin()->first) == 2.5F);
    }

    TEST_CASE("the transform gives each gray value back, however the view is turned") {
        std::vector<Vertex> vertices;
        const Volume volume =
            make_volume({511, 2, 2}, Scalar::int16, [](int x, int, int) { return x; });
        const Gp gp(volume, {0, 1});
        SlicePlanes planes;
        const SlabMesh& mesh = planes.mesh(gp.store, {2, 0, 0, 510}, 0, 0, false);
        Camera camera;
        camera.width_px = camera.height_px = 64;
        camera.voxel_to_eye = glm::dmat4(0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1);
        const auto screen = transformed(mesh.vertices, with_gray_values(prepare(camera)));
        for (std::size_t x = 0; x < 511; ++x) {
            CHECK(screen[x].nx == 0);
            CHECK(screen[x].ny == 0);
            CHECK(screen[x].nz == std::min<int>(static_cast<int>(x) + 1, 510));
        }
    }

    TEST_CASE("a triangle's origin names the voxel of its square, and no case") {
        const Volume volume = counted();
        const Gp gp(volume, {0, 1});
        SlicePlanes planes;
        const auto origin_of = [&](int axis, std::size_t triangle) {
            const SlabMesh& mesh = planes.mesh(gp.store, {axis, 3, 0, 1}, 3, 0, true);
            CHECK(mesh.origins.size() == mesh.indices.size() / 3);
            return mesh.origins[triangle];
        };
        CHECK(origin_of(0, 5) == Origin{3, 2, 0, 0, 1, 0});
        CHECK(origin_of(1, 5) == Origin{2, 3, 0, 0, 1, 0});
        CHECK(origin_of(2, 2 * (nx - 1) + 4) == Origin{2, 1, 0, 0, 0, 0});
    }

    TEST_CASE("a large slice has several pieces, which meet") {
        const Volume volume =
            make_volume({400, 300, 2}, Scalar::int16, [](int x, int y, int) { return x + y; });
        const SlicePlane plane{2, 1, 0, 700};
        CHECK(plane_pieces(plane, volume.shape, 0) == 5);
        const Corners corners = corners_of(volume, plane);
        CHECK(corners.grays.size() == 400 * 300);
        CHECK(corners.meets);
        CHECK(corners.triangles == 2 * 399 * 299);
        CHECK(plane_pieces({0, 1, 0, 700}, volume.shape, 0) == 1);
    }

    TEST_CASE("values of many planes are forgotten, and read again") {
        const Volume volume = counted();
        const Gp gp(volume, {0, 1});
        SlicePlanes planes;
        const auto grays_of = [&](int axis, int index) {
            std::vector<int> grays;
            for (const Vertex& v :
                 planes.mesh(gp.store, {axis, index, 0, 700}, 3, 0, false).vertices) {
                grays.push_back(v.normal[2]);
            }
            return grays;
        };
        std::map<std::pair<int, int>, std::vector<int>> first;
        for (const int round : {1, 2}) {
            for (int axis = 0; axis < 3; ++axis) {
                for (int index = 0; index < 5; ++index) {
                    if (axis < 2 || index == 3) {
                        const auto grays = grays_of(axis, index);
                        const auto [at, is_new] = first.try_emplace({axis, index}, grays);
                        CHECK(is_new == (round == 1));
                        CHECK(at->second == grays);
                    }
                }
            }
        }
    }

    TEST_CASE("a slice that the volume does not have is refused") {
        const VolumeShape shape = counted().shape;
        CHECK(plane_refusal({2, nz - 1, 0, 1}, shape).empty());
        CHECK(plane_refusal({2, nz, 0, 1}, shape) ==
              "slice 6 across z was requested, but the volume has slices 0 to 5");
        CHECK(plane_refusal({0, nx, 0, 1}, shape) ==
              "slice 7 across x was requested, but the volume has slices 0 to 6");
    }
}
