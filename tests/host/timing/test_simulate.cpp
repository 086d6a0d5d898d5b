#include <doctest/doctest.h>

#include <cmath>

#include "host/base/error.hpp"
#include "host/timing/simulate.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

using namespace testing;

namespace {

Machine one_of_each() {
    Machine machine = round_machine();
    machine.gps = machine.renderers = machine.frame_buffers = 1;
    return machine;
}

std::string refusal(const Machine& machine, const StepWork& step) {
    try {
        simulate(machine, {{step}, {}});
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::bad_data);
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("a frame of one region takes what its steps take, one behind the other") {
    FrameWork frame = frame_of(128, 128, 1, 2);
    // All in ns. Places: host 0, GP 1, Renderer 2, ports 3 and 4.
    constexpr Ns master = 100'000 + 64'000 + 66 * 50 + 50  // Host, link, packet and hop.
                          + 10'000 + 40 * 25;              // The GP takes it; begins 1 region.
    // BeginFrame to Renderer and frame buffer, the region's assignment and its message; then
    // 2 primitives and 68 words.
    constexpr Ns ready = master + 2 * 10'000 + 40 * 25 + 10'000 + (2 * 1000 + 68 * 10) * 25;
    // The bin's message, packet and hop; the prologue is over long before. 2 primitives, then the
    // end of the region and the port.
    constexpr Ns drawn = ready + 10'000 + 70 * 50 + 50 + 2 * 232 * 25 + 4'000 * 25 + 16'000 * 25;

    SUBCASE("a pass is done with one word, a hop farther") {
        frame.reads_out = false;
        const RunTime time = simulate(one_of_each(), {{frame}, {}});
        REQUIRE(time.steps.size() == 1);
        CHECK(time.steps[0].begin == 0);
        CHECK(time.steps[0].end == drawn + 3 * 50 + 50);
    }
    SUBCASE("a picture is shown at the first retrace behind its last pixel") {
        // 16 packets of 1026 words: 821 us more; the first retrace of 50 Hz is at 20 ms.
        CHECK(simulate(one_of_each(), {{frame}, {}}).steps[0].end == 20'000'000);
        // Half a microsecond before the last pixel and behind it.
        const auto shown_at = [&](double refresh_s) {
            Machine machine = one_of_each();
            machine.frame_buffer_refresh_hz = 1 / refresh_s;
            return static_cast<double>(simulate(machine, {{frame}, {}}).steps[0].end) * 1e-9;
        };
        constexpr double last_pixel_s = (drawn + 16 * 1026 * 50 + 50) * 1e-9;
        constexpr double half_us = 0.5e-6, ns = 1e-9;
        const double later = shown_at(last_pixel_s + half_us);
        CHECK(std::abs(later - (last_pixel_s + half_us)) <= ns);
        const double too_late = shown_at(last_pixel_s - half_us);
        CHECK(std::abs(too_late - 2 * (last_pixel_s - half_us)) <= ns);
    }
}

TEST_CASE("what cannot be replayed is refused with both values") {
    const Machine machine = one_of_each();
    FrameWork frame = frame_of(128, 128, 1, 2);
    frame.parts[1].region = 1;
    CHECK(refusal(machine, frame) ==
          "step 0: frame 0: a part of region 1; 128 x 128 pixels in 1 views have 1");
    frame.parts[1].region = 0;
    frame.parts[1].surface = 3;
    CHECK(refusal(machine, frame) ==
          "step 0: frame 0, region 0: a part of surface 3; the frame draws 1");
    CHECK(refusal(machine, BuildWork{}).find("none was loaded before") != std::string::npos);
    CHECK(refusal(machine, VolumeWork{"v", 2, 2, 2, 1, {4}}) ==
          "step 0: v: runs of 1 slices are counted; it has 2");
    CHECK(refusal(machine, FrameWork{}).find("0 x 0 pixels; 1..8192") != std::string::npos);
}

TEST_CASE("work of hours is refused, not summed until it runs over") {
    FrameWork frame = frame_of(128, 128, 1, 2);
    frame.drawn[0].primitives = std::uint64_t{1} << 32;
    // 2^32 x 1000 cycles of 25 ns.
    CHECK(refusal(one_of_each(), frame).find("1.07e+14 ns; at most 1e+13") != std::string::npos);
    ++frame.drawn[0].primitives;
    CHECK(refusal(one_of_each(), frame).find("4294967297 primitives; at most 4294967296") !=
          std::string::npos);
}

TEST_CASE("a recorded assignment needs as many Renderers") {
    Machine machine = one_of_each();
    machine.assignment = Assignment::recorded;
    const FrameWork frame = frame_of(256, 128, 2, 1);
    CHECK(refusal(machine, frame).empty());
    machine.renderers = 2;
    CHECK(refusal(machine, frame).find("to 1 Renderers; the machine has 2") != std::string::npos);
}

}  // namespace pxpl5::host::timing
