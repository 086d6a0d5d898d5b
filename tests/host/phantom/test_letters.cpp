#include <doctest/doctest.h>

#include "tests/host/phantom/phantom_probe.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

/// A reader who faces a side of the block from outside.
struct Reader {
    const char* letter;
    glm::dvec3 middle_mm, right, up;  ///< Place and axes of the letter, LPS.
    double unit_mm;                   ///< Letters are 4 units wide and 6 high.
};

// Left, posterior and superior are the positive axes. Right = looking direction x up.
const Reader readers[] = {
    {"A", {-22, -21.5, 16}, {1, 0, 0}, {0, 0, 1}, 6},
    {"P", {-22, 21.5, 16}, {-1, 0, 0}, {0, 0, 1}, 6},
    {"R", {-45.5, 0, 4}, {0, -1, 0}, {0, 0, 1}, 6},
    {"L", {45.5, 0, -24}, {0, 1, 0}, {0, 0, 1}, 5},
    {"S", {-22, 0, 47.5}, {-1, 0, 0}, {0, -1, 0}, 4},
    {"I", {0, 0, -47.5}, {1, 0, 0}, {0, -1, 0}, 4},
};

/// Whether ink is at a place of the letter, in units from its lower left corner.
bool ink(const Probe& probe, const Reader& reader, double right, double up) {
    const glm::dvec3 p =
        reader.middle_mm + reader.unit_mm * ((right - 2) * reader.right + (up - 3) * reader.up);
    return probe.near_mm(p.x, p.y, p.z) >= 500.5;
}

bool inside(const Probe& probe, double x, double y, double z) {
    return probe.near_mm(x, y, z) >= 500.5;
}

}  // namespace

TEST_SUITE("host/phantom/letters") {
    TEST_CASE("the block is an L to somebody who faces the patient") {
        const Probe probe("phantom:letters");
        CHECK(inside(probe, -22, 0, 30));  // The stem, on the patient's right.
        CHECK_FALSE(inside(probe, 22, 0, 30));
        CHECK(inside(probe, -22, 0, -24));  // The foot, on both.
        CHECK(inside(probe, 22, 0, -24));
    }

    TEST_CASE("L on the left, with its foot to the reader's right") {
        const Probe probe("phantom:letters");
        const Reader& reader = readers[3];
        CHECK(ink(probe, reader, 0, 5));
        CHECK(ink(probe, reader, 3.5, 0));
        CHECK_FALSE(ink(probe, reader, 4, 5));
        CHECK_FALSE(ink(probe, reader, 3.5, 6));
    }

    TEST_CASE("R on the right and P behind, with the bow above and at the reader's right") {
        const Probe probe("phantom:letters");
        for (const int i : {1, 2}) {
            CAPTURE(readers[i].letter);
            CHECK(ink(probe, readers[i], 0, 2));
            CHECK(ink(probe, readers[i], 4, 4.6));
            CHECK_FALSE(ink(probe, readers[i], 4, 2.2));
            CHECK(ink(probe, readers[i], 4, 0) == (i == 2));  // Only R has a leg.
        }
    }

    TEST_CASE("A in front, its point upwards") {
        const Probe probe("phantom:letters");
        CHECK(ink(probe, readers[0], 2, 6));
        CHECK(ink(probe, readers[0], 0, 0));
        CHECK(ink(probe, readers[0], 4, 0));
        CHECK_FALSE(ink(probe, readers[0], 2, 0));
        CHECK_FALSE(ink(probe, readers[0], 0, 6));
    }

    TEST_CASE("S above, not mirrored, and I below") {
        const Probe probe("phantom:letters");
        CHECK(ink(probe, readers[4], 0, 4.4));
        CHECK_FALSE(ink(probe, readers[4], 4, 4));
        CHECK(ink(probe, readers[4], 4, 1.4));
        CHECK_FALSE(ink(probe, readers[4], 0, 2));
        CHECK(ink(probe, readers[5], 2, 3));
        CHECK(ink(probe, readers[5], 1, 0));
        CHECK_FALSE(ink(probe, readers[5], 0, 3));
        CHECK_FALSE(ink(probe, readers[5], 4, 3));
    }
}
