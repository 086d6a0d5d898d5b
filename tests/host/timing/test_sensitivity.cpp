#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/timing/sensitivity.hpp"
#include "tests/host/timing/cases.hpp"

namespace pxpl5::host::timing {

using namespace testing;

namespace {

const Sensitivity& of(const std::vector<Sensitivity>& all, std::string_view name) {
    const auto found =
        std::ranges::find(all, name, [](const auto& s) { return s.parameter->name; });
    REQUIRE(found != all.end());
    return *found;
}

}  // namespace

TEST_CASE("a value to try is 20 % away, of whole numbers the nearest other one within the range") {
    const Parameter any{"any", "us", nullptr, 0, 100, false};
    const Parameter whole{"whole", "ports", nullptr, 1, 10, true};
    CHECK(trial_value(any, 10, -1) == 8.0);
    CHECK(trial_value(any, 10, 1) == 12.0);
    CHECK(trial_value(any, 90, 1) == std::nullopt);
    CHECK(trial_value(any, 0, 1) == std::nullopt);
    CHECK(trial_value(whole, 2, -1) == 1.0);  // 1.6 would be 2 again.
    CHECK(trial_value(whole, 2, 1) == 3.0);
    CHECK(trial_value(whole, 8, 1) == 10.0);  // 9.6.
    CHECK(trial_value(whole, 1, -1) == std::nullopt);
    CHECK(trial_value(whole, 10, 1) == std::nullopt);
}

TEST_CASE("each figure's change with each parameter is in percent, the greatest first") {
    const Machine machine = small_machine();
    const std::vector<PaperCase> cases = {small_case(4, 10, 5), small_case(4, 500, 50)};
    std::size_t last_done = 0, last_all = 0;
    const auto all = sensitivity(machine, cases, [&](std::size_t done, std::size_t count) {
        CHECK(done == last_done + 1);
        last_done = done;
        last_all = count;
    });
    REQUIRE(all.size() == parameters().size());
    CHECK(last_done == all.size());
    CHECK(last_all == all.size());
    for (std::size_t i = 1; i < all.size(); ++i) {
        CHECK(all[i - 1].greatest_percent() >= all[i].greatest_percent());
    }

    // 500 triangles of 400 cycles of 25 ns are 5 ms of the build.
    const Sensitivity& triangle = of(all, "gp.build_triangle_cycles");
    CHECK(triangle.value == 400);
    REQUIRE(triangle.lower);
    REQUIRE(triangle.upper);
    CHECK(triangle.lower->value == 320);
    CHECK(triangle.upper->value == 480);
    const double built_ms = time_of(machine, cases[1]).built_ms;
    REQUIRE(triangle.upper->changes.size() == 2);
    CHECK(triangle.upper->changes[1].built_percent == doctest::Approx(100 * 1.0 / built_ms));
    CHECK(triangle.lower->changes[1].built_percent == doctest::Approx(-100 * 1.0 / built_ms));
    CHECK(triangle.upper->changes[1].rate_percent == 0);
    CHECK(triangle.upper->changes[0].built_percent < triangle.upper->changes[1].built_percent);

    const Sensitivity& draw = of(all, "gp.draw_primitive_cycles");
    CHECK(draw.upper->changes[1].rate_percent < 0);
    CHECK(draw.lower->changes[1].rate_percent > 0);
    CHECK(draw.upper->changes[1].built_percent == 0);
    CHECK(draw.greatest_percent() ==
          std::max(draw.lower->greatest_percent(), draw.upper->greatest_percent()));

    CHECK(of(all, "gp.gradient_cycles").greatest_percent() == 0);
    CHECK(!of(all, "frames_in_flight").lower);  // It is 1 already.
    CHECK(of(all, "frames_in_flight").upper->value == 2);
}

}  // namespace pxpl5::host::timing
