// Pairs of pictures for a head-mounted display: their rate, and how late they are.
#include <doctest/doctest.h>

#include <set>

#include "host/timing/headset.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

using namespace testing;

namespace {

/// The pair that has the counts of one view twice.
FrameWork pair_of(const FrameWork& one) {
    FrameWork pair = one;
    pair.views = 2;
    for (DrawnSlab& slab : pair.drawn) {
        slab.primitives *= 2;
    }
    const auto regions = static_cast<std::uint32_t>(one.regions());
    for (PartWork part : one.parts) {
        part.region += regions;
        pair.parts.push_back(part);
    }
    for (const std::uint16_t renderer : one.assignment) {
        pair.assignment.push_back(renderer);
    }
    return pair;
}

Machine busy_machine() {
    Machine machine = round_machine();
    machine.gps = 2;
    machine.renderers = 2;
    machine.frames_in_flight = 2;
    machine.assignment = Assignment::round_robin;
    return machine;
}

}  // namespace

TEST_SUITE("host/timing/headset") {
    TEST_CASE("every number of the display has a name of its own, a unit and a source") {
        const Headset headset;
        std::set<std::string_view> names;
        for (const HeadsetRow& row : headset_rows()) {
            CHECK(names.insert(row.name).second);
            CHECK(!row.unit.empty());
            CHECK(!row.source.empty());
            CHECK(headset.*row.value > 0);
        }
        CHECK(names.contains("tracker.most_ms"));
    }

    TEST_CASE("a field of NTSC takes 16.7 ms, and a picture waits for half of one on average") {
        const Headset headset;
        CHECK(headset.field_ms() == doctest::Approx(16.683).epsilon(1e-4));
        CHECK(headset.wait_ms() == doctest::Approx(8.342).epsilon(1e-4));
        CHECK(headset.scan_out_ms() == doctest::Approx(16.683).epsilon(1e-4));
    }

    TEST_CASE("where GPs are the limit, pairs come half as often as single pictures") {
        const FrameWork one = frame_of(128, 128, 2, 5000);
        const Machine machine = busy_machine();
        const Rate mono = frame_rate(headset_machine(machine, {}), one);
        const HeadsetTime pairs = headset_time(machine, {}, pair_of(one));
        REQUIRE(mono.limit == Unit::gp);
        CHECK(pairs.rate.limit == Unit::gp);
        CHECK(pairs.rate.frames_per_s == doctest::Approx(mono.frames_per_s / 2).epsilon(0.02));
    }

    TEST_CASE("the latency is the tracker's, the drawing's, half a field and a field") {
        const FrameWork pair = pair_of(frame_of(128, 128, 2, 5000));
        const Headset headset;
        const HeadsetTime time = headset_time(busy_machine(), headset, pair);
        CHECK(time.drawn_ms > 0);
        CHECK(time.drawn_ms < static_cast<double>(time.rate.latency) / 1e6);
        CHECK(time.least_ms == doctest::Approx(time.drawn_ms + 20 + 1.5 * 1000 / 59.94));
        CHECK(time.most_ms == doctest::Approx(time.least_ms + 40));
    }

    TEST_CASE("the display's machine differs in its frame buffers and their fields alone") {
        Machine machine = busy_machine();
        const Machine changed = headset_machine(machine, {});
        CHECK(changed.frame_buffers == 2);
        CHECK(changed.frame_buffer_refresh_hz == 59.94);
        CHECK(changed.gps == machine.gps);
        for (const Parameter& parameter : parameters()) {
            if (parameter.name != "frame_buffer.refresh_hz") {
                CHECK(changed.*parameter.value == machine.*parameter.value);
            }
        }
    }
}

}  // namespace pxpl5::host::timing
