#include <doctest/doctest.h>

#include "gp_firmware/volume/gradient.hpp"
#include "gp_firmware/volume/voxel_gradient.hpp"
#include "tests/gp_firmware/test_volume.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::Gp;
using pxpl5::test::make_volume;
using pxpl5::test::Size;

namespace {

/// Whether all gradients that a single GP estimates are `expected`, borders included.
void check_all_gradients(const pxpl5::test::Volume& volume, Gradient expected) {
    const Gp gp(volume, {0, 1});
    for (int z = 0; z < volume.shape.nz; ++z) {
        REQUIRE(gp.store.slice(z).gradients.size() == volume.shape.slice_voxels());
        for (const Gradient& g : gp.store.slice(z).gradients) CHECK(g == expected);
    }
}

}  // namespace

TEST_SUITE("gp/gradient") {
    TEST_CASE("the gradient of a linear field is twice its slope per voxel, borders included") {
        const auto field = [](int x, int y, int z) { return 100.0 + 2 * x - 3 * y + 7 * z; };
        const auto up = [](int x, int y, int z) { return 100.0 + 2 * x + 3 * y + 7 * z; };
        for (const Size size : {Size{5, 4, 6}, Size{2, 2, 2}, Size{3, 2, 3}, Size{70, 3, 4}})
            check_all_gradients(make_volume(size, Scalar::int16, field), {4, -6, 14});
        check_all_gradients(make_volume({5, 4, 6}, Scalar::uint8, up), {4, 6, 14});
        check_all_gradients(make_volume({5, 4, 6}, Scalar::uint16, up), {4, 6, 14});
    }

    TEST_CASE("ranges beyond 16 bits, and floats, are scaled so that the steepest border fits") {
        const auto volume =
            make_volume({2, 2, 2}, Scalar::uint16, [](int x, int, int) { return x * 65535.0; });
        check_all_gradients(volume, {32767, 0, 0});
        const auto falling =
            make_volume({2, 2, 2}, Scalar::float32, [](int, int y, int) { return y * -1e-3; });
        check_all_gradients(falling, {0, -32767, 0});
        // 4 steps of 1 are the range; 2 * 4 is 32767, so a central difference of 2 is a quarter.
        const auto slope =
            make_volume({5, 2, 2}, Scalar::float32, [](int x, int, int) { return 1.0 * x; });
        check_all_gradients(slope, {8192, 0, 0});
    }

    TEST_CASE("16-bit values are exact as long as twice their range fits") {
        VolumeShape shape{2, 2, 2, Scalar::int16, glm::dmat4(1.0), 0, 16383};
        CHECK(gradient_scale(shape) == 1);
        shape.maximum = 16384;
        CHECK(gradient_scale(shape) == doctest::Approx(32767.0 / 32768));
    }

    TEST_CASE("differences with a voxel that is not a number are 0, and only those") {
        const double nan = std::numeric_limits<double>::quiet_NaN();
        const auto volume = make_volume({5, 3, 3}, Scalar::float32, [&](int x, int y, int z) {
            return x == 2 && y == 1 && z == 1 ? nan : 1.0 * x;
        });
        const Gp gp(volume, {0, 1});
        const auto& gradients = gp.store.slice(1).gradients;
        CHECK(gradients[5 + 1] == Gradient{0, 0, 0});
        CHECK(gradients[5 + 2] == Gradient{8192, 0, 0});
        CHECK(gradients[5 + 4] == Gradient{8192, 0, 0});
        CHECK(gradients[2] == Gradient{8192, 0, 0});
    }

    TEST_CASE("a gradient estimated by itself has the bits of the whole slice's") {
        std::mt19937 random(pxpl5::test::seed_or<std::uint64_t>(20));
        for (const Scalar type : {Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32})
            for (const double top : {200.0, 30000.0}) {
                const auto volume = make_volume({7, 5, 4}, type, [&](int, int, int) {
                    return std::uniform_real_distribution<>(0, std::min(top, 255.0))(random) *
                           (type == Scalar::uint8 ? 1 : top / 200);
                });
                const Gp gp(volume, {0, 1});
                for (int z = 0; z < volume.shape.nz; ++z) {
                    const auto& whole = gp.store.slice(z).gradients;
                    with_scalar(type, [&]<class T>(T) {
                        const VoxelGradients<T> single(volume.shape, gp.store.neighbors(z));
                        for (std::size_t i = 0; i < whole.size(); ++i)
                            CHECK(single.at(i % 7, i / 7) == whole[i]);
                    });
                }
            }
    }

    TEST_CASE("a volume of one value has no gradient") {
        const auto field = [](int, int, int) { return 3.0; };
        check_all_gradients(make_volume({3, 3, 3}, Scalar::float32, field), {0, 0, 0});
        check_all_gradients(make_volume({3, 3, 3}, Scalar::uint8, field), {0, 0, 0});
    }
}
