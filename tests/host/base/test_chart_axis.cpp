#include <doctest/doctest.h>

#include <vector>

#include "host/base/chart_axis.hpp"

using namespace pxpl5::host;

TEST_SUITE("host/chart_axis") {
    TEST_CASE("ticks are round, within the axis, and not too many") {
        CHECK(linear_axis(-1000, 3000, 12).ticks ==
              std::vector<double>{-1000, -500, 0, 500, 1000, 1500, 2000, 2500, 3000});
        CHECK(linear_axis(0.03, 0.21, 5).ticks.size() == 4);  // 0.05, 0.1, 0.15, 0.2
        CHECK(axis_from_zero(42900, 5).ticks == std::vector<double>{0, 20000, 40000, 60000});
        CHECK(axis_from_zero(40000, 5).high == 40000);
        CHECK(axis_from_zero(0, 5).high == 1);
        CHECK(logarithmic_axis(1, 5000, 6).ticks == std::vector<double>{1, 10, 100, 1000});
        CHECK(logarithmic_axis(1, 1e8, 5).ticks == std::vector<double>{1, 100, 1e4, 1e6, 1e8});
        CHECK(logarithmic_axis(700, 800, 5).ticks == std::vector<double>{1000});
    }

    TEST_CASE("an axis shows its ends at its ends") {
        const ChartAxis line = linear_axis(-50, 150, 5);
        CHECK(line.place(-50) == 0);
        CHECK(line.place(0) == doctest::Approx(0.25));
        CHECK(line.place(999) == 1);
        const ChartAxis decades = logarithmic_axis(1, 1000, 5);
        CHECK(decades.place(0) == 0);
        CHECK(decades.place(100) - decades.place(10) ==
              doctest::Approx(decades.place(10) - decades.place(1)));
    }

    TEST_CASE("numbers have their thousands apart") {
        CHECK(grouped(0) == "0");
        CHECK(grouped(999) == "999");
        CHECK(grouped(-1234567) == "-1,234,567");
        CHECK(grouped(41708) == "41,708");
        CHECK(grouped(0.25) == "0.25");
        CHECK(grouped(1234.5) == "1,234.5");
    }

    TEST_CASE("an axis of octaves begins and ends at powers of two") {
        CHECK(octave_axis(1, 64, 8).ticks == std::vector<double>{1, 2, 4, 8, 16, 32, 64});
        CHECK(octave_axis(1, 64, 4).ticks == std::vector<double>{1, 4, 16, 64});
        const ChartAxis odd = octave_axis(0.7, 5, 8);
        CHECK(odd.low == 0.5);
        CHECK(odd.high == 8);
        CHECK(odd.place(2) == doctest::Approx(0.5));
        CHECK(octave_axis(4, 4, 8).ticks == std::vector<double>{4, 8});
    }
}
