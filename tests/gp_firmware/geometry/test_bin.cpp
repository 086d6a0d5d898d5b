#include <doctest/doctest.h>

#include "gp_firmware/geometry/bin.hpp"

using namespace pxpl5::gp;

namespace {

ScreenVertex at(int x, int y) {
    ScreenVertex v;
    v.x = x;
    v.y = y;
    return v;
}

}  // namespace

TEST_SUITE("gp/bin") {
    TEST_CASE("regions are counted row by row, the last ones partly beyond the picture") {
        const RegionGrid grid = region_grid(300, 128, 0);
        CHECK(grid.columns == 3);
        CHECK(grid.rows == 1);
        CHECK(region_grid(300, 129, 2).first_region == 12);
    }
    TEST_CASE("a box holds the pixels whose centers it holds, borders included") {
        const RegionGrid grid = region_grid(512, 512, 0);
        const PixelBox box = pixel_box(at(8, 24), at(40, 24), at(20, 25), grid);
        CHECK(box.x0 == 0);
        CHECK(box.x1 == 2);
        CHECK(box.y0 == 1);
        CHECK(box.y1 == 1);
        const PixelBox inner = pixel_box(at(9, 23), at(39, 41), at(20, 25), grid);
        CHECK(inner.x0 == 1);
        CHECK(inner.x1 == 1);
        CHECK(inner.y0 == 1);
        CHECK(inner.y1 == 2);
    }
    TEST_CASE("a triangle between centers has an empty box") {
        const RegionGrid grid = region_grid(512, 512, 0);
        CHECK(pixel_box(at(9, 0), at(23, 900), at(20, 25), grid).empty());
        CHECK(pixel_box(at(0, 9), at(900, 23), at(20, 20), grid).empty());
        CHECK(!pixel_box(at(9, 0), at(24, 900), at(20, 25), grid).empty());
    }
    TEST_CASE("a box ends at the picture") {
        const RegionGrid grid = region_grid(100, 50, 0);
        const PixelBox box = pixel_box(at(-5000, -5000), at(9000, 70), at(20, 9000), grid);
        CHECK(box.x0 == 0);
        CHECK(box.y0 == 0);
        CHECK(box.x1 == 99);
        CHECK(box.y1 == 49);
        CHECK(pixel_box(at(-500, 0), at(-9, 70), at(-20, 900), grid).empty());
        CHECK(pixel_box(at(1600, 0), at(1900, 70), at(2000, 900), grid).empty());
    }
}
