// Histograms and plateaus: what helps to choose an isovalue.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "host/surface/atlas/histogram.hpp"
#include "host/surface/atlas/plateaus.hpp"

using namespace pxpl5;
using namespace pxpl5::host;

namespace {

template <class T>
Volume volume_of(Scalar type, const std::vector<T>& values) {
    Volume volume;
    volume.nx = static_cast<int>(values.size());
    volume.ny = volume.nz = 1;
    volume.type = type;
    volume.values.resize(values.size() * sizeof(T));
    std::memcpy(volume.values.data(), values.data(), volume.values.size());
    return volume;
}

using Counts = std::vector<std::uint64_t>;

/// Rows at isovalues 0, step, 2 step, ... up to 100; growth(isovalue) is a natural logarithm.
template <class Triangles, class Growth>
std::vector<AtlasRow> rows_of(int step, Triangles log_triangles, Growth log_volume) {
    std::vector<AtlasRow> rows;
    for (int isovalue = 0; isovalue <= 100; isovalue += step) {
        AtlasRow row;
        row.isovalue = isovalue;
        row.triangles =
            static_cast<std::uint64_t>(std::round(1e6 * std::exp(log_triangles(isovalue))));
        row.volume_mm3 = 5000 * std::exp(log_volume(isovalue));
        rows.push_back(row);
    }
    return rows;
}

double flat(int) {
    return 0;
}

/// Flat from 20 to 60, a tenth per step elsewhere.
double flat_in_between(int isovalue) {
    return isovalue < 20 ? 0.1 * (isovalue - 20) : isovalue > 60 ? -0.1 * (isovalue - 60) : 0.0;
}

}  // namespace

TEST_SUITE("host/surface/histogram") {
    TEST_CASE("each value is counted in its bin, in all types") {
        const Histogram bytes =
            histogram(volume_of<std::uint8_t>(Scalar::uint8, {250, 255, 255, 253, 250, 250}), 6);
        CHECK(bytes.first == 250);
        CHECK(bytes.width == 1);
        CHECK(bytes.counts == Counts{3, 0, 0, 1, 0, 2});
        const Histogram shorts =
            histogram(volume_of<std::int16_t>(Scalar::int16, {-32768, 32767, -1, 0, 0}), 2);
        CHECK(shorts.first == -32768);
        CHECK(shorts.width == 32768);
        CHECK(shorts.counts == Counts{2, 3});
        const Histogram words =
            histogram(volume_of<std::uint16_t>(Scalar::uint16, {65535, 65530, 65533}), 3);
        CHECK(words.first == 65530);
        CHECK(words.width == 2);
        CHECK(words.counts == Counts{1, 1, 1});
        const Histogram floats =
            histogram(volume_of<float>(Scalar::float32, {-1, 3, 0, 0.5F, 2.5F, 1.5F, 3}), 4);
        CHECK(floats.first == -1);
        CHECK(floats.width == 1);
        CHECK(floats.counts == Counts{1, 2, 1, 3});
    }

    TEST_CASE("bins of whole numbers hold equally many of them") {
        std::vector<std::int16_t> values(1000);
        std::iota(values.begin(), values.end(), std::int16_t{-500});
        const Histogram found = histogram(volume_of(Scalar::int16, values), 256);
        CHECK(found.width == 4);
        CHECK(found.counts == Counts(250, 4));
    }

    TEST_CASE("values that are not finite are counted apart") {
        const float nan = std::nanf(""), infinity = std::numeric_limits<float>::infinity();
        const Histogram some =
            histogram(volume_of<float>(Scalar::float32, {nan, 1, infinity, -infinity, 2}), 2);
        CHECK(some.not_finite == 3);
        CHECK(some.counts == Counts{1, 1});
        const Histogram none = histogram(volume_of<float>(Scalar::float32, {nan, nan}), 2);
        CHECK(none.not_finite == 2);
        CHECK(none.counts.empty());
        const Histogram one = histogram(volume_of<float>(Scalar::float32, {7, 7, 7}), 9);
        CHECK(one.first == 7);
        CHECK(one.counts == Counts{3});
    }
}

TEST_SUITE("host/surface/plateaus") {
    TEST_CASE("a plateau is where triangles and volume both stay") {
        using Found = std::vector<AtlasPlateau>;
        CHECK(find_plateaus(rows_of(1, flat_in_between, flat_in_between)) == Found{{20, 60}});
        CHECK(find_plateaus(rows_of(1, flat_in_between, flat)) == Found{{20, 60}});
        CHECK(find_plateaus(rows_of(1, flat, flat_in_between)) == Found{{20, 60}});
        CHECK(find_plateaus(rows_of(1, flat, flat)) == Found{{0, 100}});
        const auto steep = [](int isovalue) { return -0.05 * isovalue; };
        CHECK(find_plateaus(rows_of(1, flat, steep)).empty());
        CHECK(find_plateaus(rows_of(1, steep, flat)).empty());
    }

    TEST_CASE("two plateaus are apart, and a narrow one is none") {
        const auto two = [](int isovalue) {
            return isovalue <= 30 ? 0.0 : isovalue < 50 ? -0.1 * (isovalue - 30) : -2.0;
        };
        CHECK(find_plateaus(rows_of(1, two, flat)) ==
              std::vector<AtlasPlateau>{{0, 30}, {50, 100}});
        for (const int width : {3, 4}) {
            const auto narrow = [width](int isovalue) {
                return isovalue < 20           ? 0.1 * (isovalue - 20)
                       : isovalue > 20 + width ? 0.1 * (isovalue - 20 - width)
                                               : 0.0;
            };
            CHECK(find_plateaus(rows_of(1, narrow, narrow)).size() == (width == 4 ? 1 : 0));
        }
    }

    TEST_CASE("slow change is a plateau, and slow means the same where rows are far apart") {
        for (const int step : {1, 10}) {
            const auto slow = [](int isovalue) { return 0.0124 * isovalue; };
            const auto fast = [](int isovalue) { return 0.0126 * isovalue; };
            CHECK(find_plateaus(rows_of(step, slow, flat)) == std::vector<AtlasPlateau>{{0, 100}});
            CHECK(find_plateaus(rows_of(step, fast, flat)).empty());
        }
    }

    TEST_CASE("nothing stays nothing, but is no plateau") {
        const auto vanishing = [](int isovalue) { return isovalue < 50 ? 0.0 : -1000.0; };
        CHECK(find_plateaus(rows_of(1, vanishing, vanishing)) ==
              std::vector<AtlasPlateau>{{0, 49}});
        CHECK(find_plateaus({}).empty());
        CHECK(find_plateaus(std::vector<AtlasRow>(1)).empty());
    }
}
