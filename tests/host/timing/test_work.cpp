#include <doctest/doctest.h>

#include "host/timing/counts/work.hpp"

namespace pxpl5::host::timing {

TEST_CASE("a frame has a region for each 128 x 128 pixels begun, in each view") {
    FrameWork frame;
    frame.width = 1280;
    frame.height = 1024;
    CHECK(frame.regions() == 80);
    frame.width = 129;
    frame.height = 128;
    frame.views = 2;
    CHECK(frame.regions() == 4);
}

TEST_CASE("a part's cycles are those of all classes of instructions") {
    PartWork part;
    part.classes[0] = {1, 10};
    part.classes[5] = {1, 5};
    CHECK(part.cycles() == 15);
}

}  // namespace pxpl5::host::timing
