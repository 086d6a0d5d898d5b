// Sweeps: which machines are tried, and that each is timed as if it were the only one.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/timing/sweep.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

namespace {

using Values = std::vector<std::string>;

VolumeWork volume(std::uint32_t nz) {
    return {"cube", 16, 16, nz, 2, std::vector<std::uint64_t>(nz, 16 * 4)};
}

BuildWork build(std::uint16_t surface, std::uint32_t revision, std::uint64_t triangles) {
    BuildWork work{surface, revision, 0.5, {}};
    for (std::uint32_t slab = 0; slab < 15; ++slab) {
        work.slabs.push_back({slab, triangles, triangles, triangles});
    }
    return work;
}

/// A load, two surfaces, one of them a second time, and frames among them.
RunWork run() {
    return {{volume(8), volume(16), build(0, 1, 10'000), testing::frame_of(256, 128, 15, 100),
             build(1, 1, 20'000), build(0, 2, 30'000), testing::frame_of(256, 256, 15, 200),
             build(1, 2, 40'000)},
            {"a sentence"}};
}

std::string refusal(std::string_view text) {
    try {
        parse_sweep(text);
    } catch (const RequestError& error) {
        CHECK(error.code == ExitCode::usage);
        return error.what();
    }
    return "no error";
}

}  // namespace

TEST_CASE("a sweep is a list, whole numbers from one to another, or by a factor") {
    CHECK(parse_sweep("ring.channel_mb_s=40,80,160").key == "ring.channel_mb_s");
    CHECK(parse_sweep("ring.channel_mb_s=40,80,160").values == Values{"40", "80", "160"});
    CHECK(parse_sweep("share=own").values == Values{"own"});
    CHECK(parse_sweep("gp.count=2..5").values == Values{"2", "3", "4", "5"});
    CHECK(parse_sweep("gp.count=7..7").values == Values{"7"});
    CHECK(parse_sweep("gp.count=1..64").values.size() == 64);
    CHECK(parse_sweep("gp.count=1..64*2").values == Values{"1", "2", "4", "8", "16", "32", "64"});
    CHECK(parse_sweep("gp.count=3..26*3").values == Values{"3", "9"});
    CHECK(parse_sweep("seed=1..9223372036854775807*9223372036854775807").values.size() == 2);
}

TEST_CASE("a sweep that is none is refused with what is wrong with it") {
    CHECK(refusal("gp.count") ==
          "--sweep gp.count: must be KEY=VALUES, as gp.count=1..64 or ring.channel_mb_s=40,80,160");
    CHECK(refusal("=1,2").starts_with("--sweep =1,2: must be KEY=VALUES"));
    CHECK(refusal("gp.count=") == "--sweep gp.count=: there is an empty value");
    CHECK(refusal("gp.count=1,,2") == "--sweep gp.count=1,,2: there is an empty value");
    CHECK(refusal("gp.count=8..4") == "--sweep gp.count=8..4: 8 is greater than 4");
    CHECK(refusal("gp.count=1..x") ==
          "--sweep gp.count=1..x: '1..x' must be FIRST..LAST or FIRST..LAST*FACTOR, whole numbers");
    CHECK(
        refusal("gp.count=1..64*1") ==
        "--sweep gp.count=1..64*1: a factor must be 2 or more, and begin at 1 or more; they are 1 "
        "and 1");
    CHECK(refusal("gp.count=0..64*2").find("begin at 1 or more; they are 2 and 0") !=
          std::string::npos);
    CHECK(refusal("seed=0..4096") == "--sweep seed=0..4096: more than 4096 values");
}

TEST_CASE("a frame's setting is its volume and each surface's newest revision") {
    const RunWork whole = run();
    const RunWork first = setting_of(whole, 3), second = setting_of(whole, 6);
    CHECK(first.steps == std::vector<StepWork>{whole.steps[1], whole.steps[2]});
    CHECK(second.steps == std::vector<StepWork>{whole.steps[1], whole.steps[4], whole.steps[5]});
    CHECK(setting_of({{testing::frame_of(128, 128, 1, 1)}, {}}, 0).steps.empty());
}

TEST_CASE("each machine of a sweep takes what it takes by itself") {
    const Topology plan = load_topology("paper-1993");
    const std::vector<SweptKey> keys = {{"gp.count", {"3", "36"}}, {"share", {"even", "own"}}};
    const RunWork whole = run();
    const std::vector<SweptMachine> machines = sweep(plan, keys, whole, 6);
    REQUIRE(machines.size() == 4);
    CHECK(machines[1].values == Values{"3", "own"});
    CHECK(machines[2].values == Values{"36", "even"});
    for (const SweptMachine& swept : machines) {
        const Machine machine = machine_of(load_topology(
            "paper-1993", {"gp.count=" + swept.values[0], "share=" + swept.values[1]}));
        const RunTime time = simulate(machine, setting_of(whole, 6));
        const auto took = [&](std::size_t i) { return time.steps[i].end - time.steps[i].begin; };
        CHECK(swept.load == took(0));
        CHECK(swept.build == took(1) + took(2));
        CHECK(took(2) > took(1));  // More triangles.
        CHECK(swept.build_limit == time.steps[2].limit);
        const Rate rate = frame_rate(machine, std::get<FrameWork>(whole.steps[6]));
        CHECK(swept.rate.frames_per_s == rate.frames_per_s);
        CHECK(swept.rate.latency == rate.latency);
    }
    CHECK(*machines[0].build > 4 * *machines[2].build);  // 5 slabs on a GP, or 1.
}

TEST_CASE("a faster ring is never slower") {
    const SweptKey key{"ring.channel_mb_s", {"1", "2", "5", "10", "40", "80", "160", "1000"}};
    const std::vector<SweptMachine> machines =
        sweep(load_topology("paper-1993", {"gp.count=6", "renderer.count=4"}), {{key}}, run(), 6);
    REQUIRE(machines.size() == key.values.size());
    for (std::size_t i = 1; i < machines.size(); ++i) {
        // Packets come in another order: a Renderer may wait for one that it had before.
        CHECK(machines[i].rate.frames_per_s >= 0.999 * machines[i - 1].rate.frames_per_s);
        CHECK(*machines[i].load <= *machines[i - 1].load);
        CHECK(*machines[i].build <= *machines[i - 1].build);
    }
    CHECK(busiest_of(machines.front().rate.use).unit ==
          Unit::frame_buffer);  // It has but two ports.
    CHECK(machines.back().rate.frames_per_s > 4 * machines.front().rate.frames_per_s);
}

TEST_CASE("a scene has nothing to load or build") {
    const RunWork scene{{testing::frame_of(128, 128, 3, 10)}, {}};
    const SweptKey key{"gp.count", {"1"}};
    const std::vector<SweptMachine> machines =
        sweep(load_topology("paper-1993"), {{key}}, scene, 0);
    CHECK(!machines.at(0).load);
    CHECK(!machines.at(0).build);
    CHECK(machines.at(0).rate.frames_per_s > 0);
}

TEST_CASE("a sweep's machines are those of all its values, the last key's first") {
    const Topology plan = load_topology("paper-1993");
    const std::vector<SweptKey> keys = {{"gp.count", {"3", "36"}},
                                        {"ring.channel_mb_s", {"40", "80", "160"}}};
    const std::vector<TriedMachine> machines = machines_of(plan, keys);
    REQUIRE(machines.size() == 6);
    for (std::size_t n = 0; n < 6; ++n) {
        CHECK(machines[n].values == Values{keys[0].values[n / 3], keys[1].values[n % 3]});
        CHECK(std::to_string(machines[n].machine.gps) == machines[n].values[0]);
        CHECK(machines[n].machine.ring_channel_mb_s == std::stod(machines[n].values[1]));
    }
    // Not only the first value of a key is tried.
    const std::vector<SweptKey> wrong = {{"gp.count", {"1"}}, {"share", {"own", "evn"}}};
    CHECK_THROWS_WITH_AS(machines_of(plan, wrong), doctest::Contains("evn"), RequestError);
}

TEST_CASE("a sweep over what no machine has is refused") {
    const Topology plan = load_topology("paper-1993");
    const auto refused = [&](std::vector<SweptKey> keys, std::size_t step, const char* text) {
        CHECK_THROWS_WITH_AS(sweep(plan, keys, run(), step), doctest::Contains(text), RequestError);
    };
    refused({{"gp.cuont", {"1"}}}, 6, "unknown key 'gp.cuont'; did you mean 'gp.count'?");
    refused({{"gp.count", {"1025"}}}, 6, "gp.count is 1025, must be 1..1024");
    refused({{"gp.count", {"1"}}}, 5, "step 5 is no frame");
    refused({{"gp.count", {"1"}}}, 99, "step 99 is no frame");
    refused({}, 6, "0 keys");
    refused({{"gp.count", {"1"}}, {"share", {"own"}}, {"seed", {"1"}}}, 6, "3 keys");
    refused({{"gp.count", {"1"}}, {"gp.count", {"2"}}}, 6, "gp.count: the key is there twice");
    refused({{"seed", Values(100, "1")}, {"gp.count", Values(41, "1")}}, 6, "4100 machines");
}

}  // namespace pxpl5::host::timing
