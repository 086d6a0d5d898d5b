#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

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

/// The definition of a smooth gradient: central differences of all voxels of a 3 x 3 x 3 block,
/// weighted by 1, 2, 1 along the two other axes; at the border by 0, 4, 0.
template <class T>
std::array<double, 3> smooth_by_definition(const pxpl5::test::Volume& volume,
                                           std::array<int, 3> p) {
    const VolumeShape& shape = volume.shape;
    const std::array sizes{shape.nx, shape.ny, shape.nz};
    const auto is_at_border = [&](std::size_t a) { return p[a] == 0 || p[a] == sizes[a] - 1; };
    std::array<double, 3> sums{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (int block = 0; block < 27; ++block) {
            const std::array<int, 3> offset{block % 3 - 1, block / 3 % 3 - 1, block / 9 - 1};
            std::array<std::size_t, 3> q{};
            double weight = offset[axis] * (is_at_border(axis) ? 2 : 1);
            for (std::size_t a = 0; a < 3; ++a) {
                q[a] = static_cast<std::size_t>(std::clamp(p[a] + offset[a], 0, sizes[a] - 1));
                if (a != axis)
                    weight *=
                        offset[a] == 0 ? (is_at_border(a) ? 4 : 2) : (is_at_border(a) ? 0 : 1);
            }
            if (weight == 0) continue;
            const T* slice = typed<T>(volume.slice(static_cast<int>(q[2])));
            sums[axis] += weight * slice[q[1] * static_cast<std::size_t>(shape.nx) + q[0]];
        }
        sums[axis] *= gradient_scale(shape) / 16;
    }
    return sums;
}

constexpr std::array all_types{Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32};

/// Values from 0 to `top`, of uint8 to 255 at most.
pxpl5::test::Volume noise(Size size, Scalar type, double top, std::mt19937& random) {
    std::uniform_real_distribution<> value(0, type == Scalar::uint8 ? std::min(top, 255.0) : top);
    return make_volume(size, type, [&](int, int, int) { return value(random); });
}

/// Values of x, but for one in the middle.
pxpl5::test::Volume ramp_with(double odd) {
    auto volume = make_volume({5, 3, 3}, Scalar::float32, [&](int x, int y, int z) {
        return x == 2 && y == 1 && z == 1 ? odd : 1.0 * x;
    });
    volume.shape.minimum = 0;
    volume.shape.maximum = 4;
    return volume;
}

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

    TEST_CASE("central differences with a voxel that is not finite are 0, and only those") {
        const double infinity = std::numeric_limits<double>::infinity();
        for (const double odd : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity}) {
            const Gp gp(ramp_with(odd), {0, 1});
            const auto& gradients = gp.store.slice(1).gradients;
            CHECK(gradients[5 + 1] == Gradient{0, 0, 0});
            CHECK(gradients[5 + 2] == Gradient{8192, 0, 0});
            CHECK(gradients[5 + 4] == Gradient{8192, 0, 0});
            CHECK(gradients[2] == Gradient{8192, 0, 0});
        }
    }

    TEST_CASE("smooth gradients are 0 along each axis where a value that is not finite enters") {
        const double infinity = std::numeric_limits<double>::infinity();
        for (const double odd : {std::numeric_limits<double>::quiet_NaN(), infinity, -infinity}) {
            auto volume = ramp_with(odd);
            volume.shape.gradient = GradientKernel::smooth;
            const Gp gp(volume, {0, 1});
            const auto& gradients = gp.store.slice(1).gradients;
            CHECK(gradients[5 + 1] == Gradient{0, 0, 0});
            CHECK(gradients[5 + 2] == Gradient{8192, 0, 0});  // Its own value enters no difference.
            CHECK(gradients[5 + 4] == Gradient{8192, 0, 0});
            CHECK(gradients[1] == Gradient{8192, 0, 0});  // At the border, no mean along y.
        }
    }

    TEST_CASE("a gradient estimated by itself has the bits of the whole slice's") {
        std::mt19937 random(pxpl5::test::seed_or<std::uint64_t>(20));
        for (const GradientKernel kernel : {GradientKernel::central, GradientKernel::smooth})
            for (const Scalar type : all_types)
                for (const double top : {200.0, 30000.0}) {
                    auto volume = noise({7, 5, 4}, type, top, random);
                    volume.shape.gradient = kernel;
                    const Gp gp(volume, {0, 1});
                    for (int z = 0; z < volume.shape.nz; ++z) {
                        const auto& whole = gp.store.slice(z).gradients;
                        with_scalar(type, [&]<class T>(T) {
                            const VoxelGradients<T> single(volume.shape, gp.store.neighbors(z));
                            for (std::size_t i = 0; i < whole.size(); ++i)
                                CHECK((kernel == GradientKernel::smooth
                                           ? single.smooth(i % 7, i / 7)
                                           : single.central(i % 7, i / 7)) == whole[i]);
                        });
                    }
                }
    }

    TEST_CASE("smooth gradients are what their definition says, borders included") {
        std::mt19937 random(pxpl5::test::seed_or<std::uint64_t>(20));
        for (const Scalar type : all_types)
            for (const Size size : {Size{7, 5, 4}, Size{2, 2, 2}, Size{3, 2, 3}}) {
                auto volume = noise(size, type, 30000, random);
                volume.shape.gradient = GradientKernel::smooth;
                const Gp gp(volume, {0, 1});
                for (int z = 0; z < size.nz; ++z)
                    for (int y = 0; y < size.ny; ++y)
                        for (int x = 0; x < size.nx; ++x) {
                            const Gradient g =
                                gp.store.slice(z)
                                    .gradients[static_cast<std::size_t>(y * size.nx + x)];
                            with_scalar(type, [&]<class T>(T) {
                                const auto wanted = smooth_by_definition<T>(volume, {x, y, z});
                                for (std::size_t axis = 0; axis < 3; ++axis)
                                    CHECK(std::abs(g[axis] - wanted[axis]) <= 0.5001);
                            });
                        }
            }
    }

    TEST_CASE("smooth gradients point along a linear field, and noise turns them less") {
        const auto field = [](int x, int y, int z) { return 100.0 + 2 * x - 3 * y + 7 * z; };
        auto linear = make_volume({5, 4, 6}, Scalar::int16, field);
        linear.shape.gradient = GradientKernel::smooth;
        const double scale = gradient_scale(linear.shape);
        const auto scaled = [scale](double slope) {
            return static_cast<std::int16_t>(std::floor(2 * slope * scale + 0.5));
        };
        check_all_gradients(linear, {scaled(2), scaled(-3), scaled(7)});
        std::mt19937 random(pxpl5::test::seed_or<std::uint64_t>(20));
        auto rough = noise({60, 60, 5}, Scalar::int16, 1000, random);
        const auto mean_square = [&rough](GradientKernel kernel) {
            rough.shape.gradient = kernel;
            const Gp gp(rough, {0, 1});
            double sum = 0;
            for (std::size_t y = 1; y < 59; ++y)
                for (std::size_t x = 1; x < 59; ++x)
                    sum += std::pow(
                        gp.store.slice(2).gradients[y * 60 + x][0] / gradient_scale(rough.shape),
                        2);
            return sum;
        };
        // Weights of 1, 2, 1 along two axes leave (6 / 16)^2 of the variance of noise.
        const double left =
            mean_square(GradientKernel::smooth) / mean_square(GradientKernel::central);
        CHECK(std::abs(left - 36.0 / 256) < 0.02);
    }

    TEST_CASE("a volume of one value has no gradient") {
        const auto field = [](int, int, int) { return 3.0; };
        check_all_gradients(make_volume({3, 3, 3}, Scalar::float32, field), {0, 0, 0});
        check_all_gradients(make_volume({3, 3, 3}, Scalar::uint8, field), {0, 0, 0});
    }
}
