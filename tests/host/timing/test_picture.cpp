// Pictures: which passes are one, and how often it is shown.
#include <doctest/doctest.h>

#include <vector>

#include "host/timing/picture.hpp"
#include "host/timing/sweep.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

namespace {

FrameWork pass(std::uint32_t frame, std::uint32_t sample, std::uint32_t samples) {
    FrameWork work = testing::frame_of(128, 128, 1, 1000);
    work.frame = frame;
    work.sample = sample;
    work.samples = samples;
    work.reads_out = sample + 1 == samples;
    return work;
}

/// The frames of all pictures, each picture's behind a 0.
std::vector<std::uint32_t> frames_of(const RunWork& run) {
    std::vector<std::uint32_t> frames;
    for (const Picture& picture : pictures_of(run)) {
        frames.push_back(0);
        for (const FrameWork* one : picture.passes) {
            CHECK(one == std::get_if<FrameWork>(&run.steps[picture.step + one->sample]));
            frames.push_back(one->frame);
        }
    }
    return frames;
}

/// A frame for each sample, from frame 1.
RunWork passes(std::uint32_t samples) {
    RunWork run;
    for (std::uint32_t sample = 0; sample < samples; ++sample) {
        run.steps.emplace_back(pass(1 + sample, sample, samples));
    }
    return run;
}

}  // namespace

TEST_CASE("a picture is a frame for each of its samples") {
    using Frames = std::vector<std::uint32_t>;
    const VolumeWork volume{"cube", 16, 16, 1, 2, {16}};
    CHECK(frames_of({{pass(1, 0, 1), volume, pass(2, 0, 1)}, {}}) == Frames{0, 1, 0, 2});
    CHECK(frames_of({{volume, pass(1, 0, 2), pass(2, 1, 2), pass(3, 0, 1)}, {}}) ==
          Frames{0, 1, 2, 0, 3});
}

TEST_CASE("a picture that lacks a pass is none") {
    using Frames = std::vector<std::uint32_t>;
    const VolumeWork volume{"cube", 16, 16, 1, 2, {16}};
    CHECK(frames_of({{pass(1, 0, 4), pass(2, 1, 4), pass(3, 0, 1)}, {}}) == Frames{0, 3});
    CHECK(frames_of({{pass(2, 1, 2), pass(3, 0, 1)}, {}}) == Frames{0, 3});
    CHECK(frames_of({{pass(1, 0, 2), volume, pass(2, 1, 2)}, {}}).empty());
    CHECK(frames_of({{pass(1, 0, 2), pass(4, 1, 2)}, {}}).empty());  // Of two pictures.
    CHECK(frames_of({{pass(1, 0, 4), pass(2, 1, 2)}, {}}).empty());
}

TEST_CASE("where a GP never waits, a picture takes as long as all its passes") {
    Machine machine = testing::round_machine();
    machine.gps = machine.renderers = 1;
    machine.assignment = Assignment::round_robin;
    machine.frames_in_flight = 2;
    // As for a frame (test_frames.cpp): drawing; DrawFrame, a region, BeginFrames and a bin.
    constexpr double pass_ns = 1000 * (1000 + 340) * 25.0 + 10'000 + 1'000 + 2 * 10'000 + 10'000;
    for (const std::uint32_t samples : {1U, 4U, 16U}) {
        const RunWork run = passes(samples);
        const Rate rate = picture_rate(machine, pictures_of(run).front());
        CHECK(rate.frames_per_s == doctest::Approx(1e9 / (samples * pass_ns)).epsilon(1e-4));
        CHECK(static_cast<double>(rate.latency) > samples * pass_ns);
        CHECK(rate.limit == Unit::gp);
    }
}

TEST_CASE("a sweep times the whole picture, whichever of its passes is named") {
    const Topology plan = load_topology("paper-1993");
    const std::vector<SweptKey> keys = {{"gp.count", {"2"}}};
    const RunWork run = passes(4);
    const Rate rate =
        picture_rate(machines_of(plan, keys).front().machine, pictures_of(run).front());
    for (const std::size_t step : {0, 3}) {
        CHECK(sweep(plan, keys, run, step).front().rate.frames_per_s == rate.frames_per_s);
    }
    CHECK(!picture_at(run, 4));
}

}  // namespace pxpl5::host::timing
