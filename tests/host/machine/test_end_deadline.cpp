// How long the end of a machine waits.
#include <doctest/doctest.h>

#include "host/machine/computers/end_deadline.hpp"

using pxpl5::host::EndDeadline;

TEST_SUITE("host/machine/end_deadline") {
    TEST_CASE("parts of files give more time than the grace") {
        EndDeadline deadline(5000, 200);
        CHECK_FALSE(deadline.is_over(5199));
        CHECK(deadline.is_over(5200));
        deadline.take_part(5100);
        CHECK(deadline.left_ms(5100) == EndDeadline::part_ms);
        CHECK_FALSE(deadline.is_over(6099));
        CHECK(deadline.is_over(6100));
        CHECK(deadline.left_ms(7000) == 0);
        EndDeadline patient(0, 60'000);
        patient.take_part(0);  // A part takes no time away.
        CHECK(patient.left_ms(0) == 60'000);
    }
    TEST_CASE("a computer that never stops sending does not keep the host") {
        EndDeadline deadline(0, 500);
        std::int64_t now_ms = 0;
        while (!deadline.is_over(now_ms) && now_ms < 10 * EndDeadline::all_parts_ms) {
            deadline.take_part(now_ms);
            now_ms += EndDeadline::part_ms / 2;
        }
        CHECK(now_ms == EndDeadline::all_parts_ms + 500);
        deadline.begin_step(now_ms, 1000);
        deadline.take_part(now_ms + 900);
        CHECK(deadline.is_over(now_ms + 1000));
    }
}
