#include <doctest/doctest.h>

#include <string>

#include "host/machine/topology.hpp"
#include "host/report/reason.hpp"

using namespace pxpl5::host;
using namespace pxpl5::host::report;
using namespace pxpl5::host::timing;

namespace {

Machine machine() {
    Machine machine = machine_of(load_topology("paper-1993"));
    machine.gps = 2;
    machine.gp_clock_mhz = 40;
    machine.gp_edge_cycles = 100;
    machine.gp_build_triangle_cycles = 2000;
    machine.gp_draw_primitive_cycles = 1000;
    machine.gp_emit_word_cycles = 4;
    return machine;
}

/// 4 x 3 voxels in 4 slices, each row of each one run: slab 0 with GP 0 has no edges along x
/// between runs, 4 x 2 along y in each of its two slices, and 12 along z; so has slab 2.
VolumeWork volume() {
    return {"v", 4, 3, 4, 1, {3, 3, 3, 3}};
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("host/report/reason") {
    TEST_CASE("a build's reason has the busiest GP's counts, and what the paper's time needs") {
        BuildWork build;
        build.slabs = {{0, 9, 9, 100}, {1, 9, 9, 999}, {2, 9, 9, 60}};
        StepTime time;
        time.end = 10'000'000;
        time.use = {
            {Unit::host, 0.7, 0.7, 0}, {Unit::host_link, 0, 0, 0}, {Unit::gp, 0.5, 0.91, 0}};
        time.limit = Unit::gp;
        // 56 edges x 100 and 160 triangles x 2000 cycles at 40 MHz; 2 ms more are a quarter more
        // triangles.
        CHECK(build_reason(machine(), volume(), build, time, 12) ==
              "GP 0 is busiest, 91 % of 10.0 ms: 56 edges looked at (0.1 ms), 160 triangles made "
              "(8.0 ms); the paper's time needs 15.29 times as many edges looked at or 1.25 times "
              "as many triangles made");
        CHECK(has(build_reason(machine(), volume(), build, time, 1), "needs") == false);
        time.use[1].busiest = 0.96;
        time.limit = Unit::host_link;
        CHECK(build_reason(machine(), volume(), build, time, 12) ==
              "host link is busiest, 96 % of 10.0 ms");
        time.use = {{Unit::host, 0.7, 0.7, 0}, {Unit::gp, 0.5, 0.6, 0}};
        time.limit = Unit::waiting;
        CHECK(build_reason(machine(), volume(), build, time, 12) ==
              "host is busiest, 70 % of 10.0 ms; the rest is waiting for other units");
    }

    TEST_CASE("a frame's reason has the counts of the unit that limits it") {
        FrameWork frame;
        frame.width = 256;
        frame.height = 128;
        frame.drawn = {{0, 0, 1000}, {0, 1, 3000}};
        PartWork part;
        part.words = 8000;
        part.classes[0] = {1, 640'000};
        frame.parts = {part};
        Rate rate;
        rate.frames_per_s = 20;
        rate.use = {{Unit::gp, 1, 1, 1}, {Unit::renderer, 0.5, 0.5, 3}};
        rate.limit = Unit::gp;
        Machine even = machine();
        even.share = Sharing::even;
        CHECK(frames_reason(even, frame, rate) ==
              "GP 1 is busiest, 100 % of 50.0 ms a frame: 2,000 primitives drawn (50.0 ms), 4,000 "
              "words put into bins (0.4 ms)");
        Machine own = machine();
        own.share = Sharing::own;
        CHECK(has(frames_reason(own, frame, rate), "3,000 primitives drawn (75.0 ms)"));
        rate.use[0].busiest = 0.4;
        rate.limit = Unit::waiting;
        even.renderers = 16;
        const std::string waits = frames_reason(even, frame, rate);
        CHECK(has(waits, "40,000 cycles a Renderer on average (1.0 ms)"));
        CHECK(has(waits, "; the rest is waiting"));
        CHECK(!has(waits, "the most expensive region"));
        frame.parts[0].classes[1] = {1, 400'000};
        CHECK(has(frames_reason(even, frame, rate),
                  "; the most expensive region alone keeps its Renderer busy for 26.0 ms"));
        rate.limit = Unit::frame_buffer;
        rate.use = {{Unit::frame_buffer, 1, 1, 0}};
        CHECK(has(frames_reason(even, frame, rate), "32,768 words of pixels"));
    }
}
