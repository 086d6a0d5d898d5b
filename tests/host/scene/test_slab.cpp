// Slabs against volumes whose mean, maximum and minimum are known.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "host/phantom/phantom.hpp"
#include "host/scene/slab.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

/// A volume of float32 whose voxel (x, y, z) has a given value, in voxels of 1 mm.
Volume volume_of(int nx, int ny, int nz, const std::function<double(int, int, int)>& value) {
    Volume v;
    v.nx = nx;
    v.ny = ny;
    v.nz = nz;
    v.type = Scalar::float32;
    for (int i = 0; i < nx * ny * nz; ++i) {
        const auto number = static_cast<float>(value(i % nx, i / nx % ny, i / (nx * ny)));
        const auto* bytes = reinterpret_cast<const std::byte*>(&number);
        v.values.insert(v.values.end(), bytes, bytes + sizeof number);
    }
    return v;
}

struct Computed {
    SlabRange range;
    Slice slice;
    std::vector<double> numbers;
};

Computed slab_of(const Volume& volume, int axis, int index, const SlabWish& wish) {
    const SlabRange range = slab_range(volume, axis, index, wish.thickness_mm);
    SlabGather gather(wish.kind);
    for (int i = range.first; i <= range.last; ++i) {
        gather.add(slice_of(volume, axis, i));
    }
    Slice slice = gather.finish();
    std::vector<double> numbers = numbers_of(slice);
    return {range, std::move(slice), std::move(numbers)};
}

std::array<int, 2> ends(const SlabRange& range) {
    return {range.first, range.last};
}

}  // namespace

TEST_SUITE("slab") {
    TEST_CASE("of a ramp: the mean is the middle, maximum and minimum are the ends") {
        const Volume ramp =
            volume_of(9, 11, 13, [](int x, int y, int z) { return 1000 + x + 20 * y + 400 * z; });
        const std::array step = {1, 20, 400};
        for (int axis = 0; axis < 3; ++axis) {
            CAPTURE(axis);
            const std::vector<double> middle = numbers_of(slice_of(ramp, axis, 4));
            const double rise = 3 * step.at(static_cast<std::size_t>(axis));
            const Computed mean = slab_of(ramp, axis, 4, {6, SlabKind::mean});
            const Computed most = slab_of(ramp, axis, 4, {6, SlabKind::max});
            const Computed least = slab_of(ramp, axis, 4, {6, SlabKind::min});
            CHECK(ends(most.range) == std::array{1, 7});
            REQUIRE(mean.numbers.size() == middle.size());
            for (std::size_t i = 0; i < middle.size(); ++i) {
                REQUIRE(mean.numbers[i] == middle[i]);
                REQUIRE(most.numbers[i] == middle[i] + rise);
                REQUIRE(least.numbers[i] == middle[i] - rise);
            }
        }
    }
    TEST_CASE("has the slices within half of the thickness, and ends with the volume") {
        const Volume v = volume_of(3, 3, 10, [](int, int, int) { return 0; });
        CHECK(ends(slab_range(v, 2, 5, 0)) == std::array{5, 5});
        CHECK(ends(slab_range(v, 2, 5, 1.99)) == std::array{5, 5});
        CHECK(ends(slab_range(v, 2, 5, 2)) == std::array{4, 6});
        CHECK(ends(slab_range(v, 2, 1, 8)) == std::array{0, 5});
        CHECK(ends(slab_range(v, 2, 9, 1e6)) == std::array{0, 9});
    }
    TEST_CASE("is measured in millimeters along the normal") {
        Volume v = volume_of(3, 3, 6, [](int, int, int) { return 0; });
        v.voxel_to_patient[2] = glm::dvec4(0, 0, 2.5, 0);
        CHECK(ends(slab_range(v, 2, 2, 5)) == std::array{1, 3});
        CHECK(ends(slab_range(v, 2, 2, 4.9)) == std::array{2, 2});
        // A gantry tilted by 60 degrees: slices 2.5 mm apart lie 1.25 mm above each other.
        v.voxel_to_patient[2] = glm::dvec4(0, 2.5 * std::sin(glm::pi<double>() / 3), 1.25, 0);
        CHECK(ends(slab_range(v, 2, 2, 5)) == std::array{0, 4});
        // Unevenly spaced slices, 1 mm a step of the grid.
        v.voxel_to_patient[2] = glm::dvec4(0, 0, 1, 0);
        v.slice_places = {0, 1, 2, 5, 6, 9};
        CHECK(ends(slab_range(v, 2, 3, 6)) == std::array{2, 4});
        CHECK(ends(slab_range(v, 0, 1, 6)) == std::array{0, 2});
    }
    TEST_CASE("the maximum of all slices of a sphere is its silhouette, the mean its chords") {
        const Volume sphere = make_phantom("phantom:sphere");  // Radius 30 mm, 0.01 mm of depth.
        const std::array counts = {sphere.nx, sphere.ny, sphere.nz};
        for (int axis = 0; axis < 3; ++axis) {
            CAPTURE(axis);
            const int count = counts.at(static_cast<std::size_t>(axis));
            const Computed most = slab_of(sphere, axis, count / 2, {1e6, SlabKind::max});
            CHECK(most.range.count() == count);
            CHECK(most.slice.type == sphere.type);
            double inside = 0, deepest = 0;
            for (const double value : most.numbers) {
                inside += value >= 0.5 ? 1 : 0;
                deepest = std::max(deepest, value);
            }
            const SliceSide &across = most.slice.frame.across, &down = most.slice.frame.down;
            const double area_mm2 = inside * across.spacing_mm * down.spacing_mm;
            CHECK(area_mm2 == doctest::Approx(glm::pi<double>() * 30 * 30).epsilon(0.01));
            // The voxel nearest to the center is at most half of a diagonal away.
            CHECK(deepest <= 3000);
            CHECK(deepest >= 3000 - 100 * std::sqrt(3.0) / 2 * across.spacing_mm - 1);
        }
    }
    TEST_CASE("keeps the type for maximum and minimum, and has float32 for the mean") {
        Volume v = volume_of(2, 2, 3, [](int, int, int) { return 0; });
        v.type = Scalar::uint8;
        v.values.assign(12, std::byte{0});
        v.values[0] = std::byte{255};
        v.values[8] = std::byte{254};
        const Computed mean = slab_of(v, 2, 1, {2, SlabKind::mean});
        CHECK(mean.slice.type == Scalar::float32);
        CHECK(mean.numbers[0] == static_cast<double>(static_cast<float>(509.0 / 3)));
        CHECK(slab_of(v, 2, 1, {2, SlabKind::max}).slice.type == Scalar::uint8);
        CHECK(slab_of(v, 2, 1, {2, SlabKind::max}).numbers[0] == 255);
        CHECK(slab_of(v, 2, 1, {2, SlabKind::min}).numbers[0] == 0);
    }
    TEST_CASE("values that are no number do not count") {
        const double none = std::numeric_limits<double>::quiet_NaN();
        const Volume v = volume_of(2, 1, 3, [&](int x, int, int z) {
            return x == 0 ? none : z == 1 ? none : -4 - z;
        });
        for (const SlabKind kind : {SlabKind::mean, SlabKind::max, SlabKind::min}) {
            const Computed slab = slab_of(v, 2, 1, {2, kind});
            CHECK(std::isnan(slab.numbers[0]));
            CHECK(slab.numbers[1] == (kind == SlabKind::mean  ? -5
                                      : kind == SlabKind::max ? -4
                                                              : -6));
        }
    }
}
