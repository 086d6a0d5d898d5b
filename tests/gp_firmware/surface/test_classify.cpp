#include <doctest/doctest.h>

#include "gp_firmware/surface/classify.hpp"
#include "tests/gp_firmware/test_volume.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::make_volume;
using pxpl5::test::seed_or;
using pxpl5::test::Volume;

namespace {

using Mask = std::vector<std::uint64_t>;

/// The definition: a voxel is inside if value >= isovalue.
Mask expected_mask(const Volume& volume, int y, double isovalue) {
    Mask mask(mask_words(volume.shape.nx));
    with_scalar(volume.shape.type, [&]<class T>(T) {
        for (int x = 0; x < volume.shape.nx; ++x) {
            const T value = typed<T>(volume.values)[y * volume.shape.nx + x];
            if (static_cast<double>(value) >= isovalue)
                mask[static_cast<std::size_t>(x / 64)] |= std::uint64_t{1} << (x % 64);
        }
    });
    return mask;
}

/// Compares the three ways to a row's mask with the definition.
void check_rows(const Volume& volume, double isovalue) {
    HeldSlice slice;
    slice.values.assign(volume.slice(0).begin(), volume.slice(0).end());
    slice.rows = index_rows(volume.shape, slice.values);
    const std::size_t row_bytes = slice.values.size() / static_cast<std::size_t>(volume.shape.ny);
    for (int y = 0; y < volume.shape.ny; ++y) {
        const Mask expected = expected_mask(volume, y, isovalue);
        Mask mask(expected.size(), 0xAAAAAAAAAAAAAAAAU);
        classify_row(volume.shape, slice, y, isovalue, mask);
        CHECK(mask == expected);
        const auto row = static_cast<std::size_t>(y);
        if (static_cast<double>(slice.rows.ranges[row].maximum) < isovalue) continue;
        mask.assign(expected.size(), 0xAAAAAAAAAAAAAAAAU);
        mask_from_voxels(volume.shape.type, slice.values.data() + row * row_bytes, volume.shape.nx,
                         isovalue, mask);
        CHECK(mask == expected);
        if (slice.rows.runs_of(y).empty()) continue;
        mask.assign(expected.size(), 0xAAAAAAAAAAAAAAAAU);
        mask_from_runs(slice.rows.runs_of(y), isovalue, mask);
        CHECK(mask == expected);
    }
}

}  // namespace

TEST_SUITE("gp/classify") {
    TEST_CASE("range, runs and voxels give the mask that the definition gives, for every type") {
        const unsigned seed = seed_or(1U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        for (const Scalar type : {Scalar::uint8, Scalar::int16, Scalar::uint16, Scalar::float32})
            for (const int nx : {2, 7, 63, 64, 65, 100, 127, 128, 129, 200, 256}) {
                double value = 100;
                const auto volume = make_volume({nx, 12, 2}, type, [&](int, int y, int) {
                    if (y < 6 || random() % 30 == 0) value = double(random() % 200);
                    return value;
                });
                for (const double isovalue : {-1.0, 0.0, 100.0, 99.5, 100.5, 199.0, 250.0, 1e9})
                    check_rows(volume, isovalue);
            }
    }

    TEST_CASE("extreme values and isovalues classify right") {
        for (const double isovalue : {-1e300, -32768.0, -32767.5, 32766.5, 32767.0, 32767.5, 1e300})
            check_rows(make_volume({70, 2, 2}, Scalar::int16,
                                   [](int x, int, int) {
                                       return x % 3 == 0 ? -32768.0 : x % 3 == 1 ? 32767.0 : 0.0;
                                   }),
                       isovalue);
        for (const double isovalue : {-1.0, 0.0, 0.5, 65534.5, 65535.0, 65535.5})
            check_rows(make_volume({70, 2, 2}, Scalar::uint16,
                                   [](int x, int, int) { return x % 2 * 65535.0; }),
                       isovalue);
    }

    TEST_CASE("a float isovalue between two floats takes the upper one as the first inside") {
        const float below = 0.1F, above = std::nextafter(below, 1.0F);
        const auto volume = make_volume({130, 2, 2}, Scalar::float32,
                                        [&](int x, int, int) { return x % 2 ? above : below; });
        for (const double isovalue :
             {double(below), (double(below) + double(above)) / 2, double(above),
              std::nextafter(double(below), 1.0), std::nextafter(double(above), 0.0)})
            check_rows(volume, isovalue);
    }

    TEST_CASE("a voxel that is not a number is outside, infinities are where they belong") {
        const double infinity = std::numeric_limits<double>::infinity();
        const double values[] = {std::nan(""), infinity, -infinity, 1, 2};
        const auto volume = make_volume({131, 3, 2}, Scalar::float32, [&](int x, int y, int) {
            return values[y == 2 ? 0 : (x + y) % 5];
        });
        for (const double isovalue : {0.5, 1.0, 1.5, 3.0, -1e30}) check_rows(volume, isovalue);
        const auto runs = make_volume({128, 2, 2}, Scalar::float32, [&](int x, int, int) {
            return x < 64 ? infinity : -infinity;
        });
        check_rows(runs, 7);
    }
}
