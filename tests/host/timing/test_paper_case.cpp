#include <doctest/doctest.h>

#include "tests/host/timing/cases.hpp"

namespace pxpl5::host::timing {

using namespace testing;

TEST_CASE("a case's build has the edges' and triangles' times, and not that of loading") {
    Machine machine = small_machine();
    const PaperCase made = small_case(4, 10, 5);
    const double before_ms = time_of(machine, made).built_ms;
    REQUIRE(edges_of(4) == 64);
    machine.gp_edge_cycles += 40'000;  // 1 ms.
    CHECK(time_of(machine, made).built_ms == doctest::Approx(before_ms + 64));
    machine.gp_build_triangle_cycles += 80'000;
    CHECK(time_of(machine, made).built_ms == doctest::Approx(before_ms + 64 + 20));
    CHECK(time_of(machine, made).build.limit == Unit::gp);
    machine.gp_gradient_cycles += 40'000;
    CHECK(time_of(machine, made).built_ms == doctest::Approx(before_ms + 64 + 20));
}

TEST_CASE("a case's rate is its frame's, and errors are shares of the paper's values") {
    const Machine machine = small_machine();
    PaperCase made = small_case(4, 10, 5);
    CaseTime time = time_of(machine, made);
    CHECK(time.rate.frames_per_s == frame_rate(machine, made.frame).frames_per_s);
    made.row.paper.built_ms = time.built_ms / 2;
    made.row.paper.frames_per_s = time.rate.frames_per_s * 4;
    time = time_of(machine, made);
    CHECK(time.built_error_percent == doctest::Approx(100));
    CHECK(time.rate_error_percent == doctest::Approx(-75));
}

}  // namespace pxpl5::host::timing
