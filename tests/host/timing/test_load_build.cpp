// Times of loads and builds, from their rules: with round_machine() a GP's cycle takes 25 ns.
#include <doctest/doctest.h>

#include <algorithm>

#include "host/timing/replay/build_model.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

using namespace testing;

namespace {

VolumeWork volume_of(std::uint32_t nx, std::uint32_t ny, std::vector<std::uint64_t> runs) {
    VolumeWork volume;
    volume.name = "v";
    volume.nx = nx;
    volume.ny = ny;
    volume.nz = static_cast<std::uint32_t>(runs.size());
    volume.voxel_bytes = 2;
    volume.runs = std::move(runs);
    return volume;
}

Machine machine_of(std::uint32_t gps, Sharing share = Sharing::even) {
    Machine machine = round_machine();
    machine.gps = gps;
    machine.share = share;
    return machine;
}

struct Sent {
    std::uint64_t packets = 0, words = 0;
};
Sent sent(const RunTime& time, std::uint16_t source, std::uint16_t destination) {
    Sent sum;
    for (const RingCount& count : time.ring) {
        if (count.source == source && count.destination == destination) {
            sum.packets += count.messages;
            sum.words += count.words;
        }
    }
    return sum;
}

Ns length(const StepTime& step) {
    return step.end - step.begin;
}

// The time of a message of `words` to the host from a GP with 17 + `gps` places of ring left to go.
Ns to_host(Ns words, Ns hops) {
    return 10'000 + (words + 2) * 50 + hops * 50 + words * 1000 + 100'000;
}

}  // namespace

TEST_CASE("a load is its slices' way to the GP, its gradients and the answer") {
    const RunTime time = simulate(machine_of(1), {{volume_of(4, 4, {4, 4, 4})}, {}});
    REQUIRE(time.steps.size() == 1);
    // Three slices of 16 voxels are 8 words each; the host's software is the slowest, the third
    // leaves it at 300 us. Then two sets of 2 x 16 voxels, 8 cycles each. Ring: GP at 1 of 20.
    constexpr Ns last_slice = 300'000 + 8'000 + 10 * 50 + 50 + 10'000;
    constexpr Ns gradients = 2 * (2 * 16 * 8 * 25);
    CHECK(time.steps[0].end == last_slice + gradients + to_host(8, 19));
    CHECK(sent(time, 0, 1).packets == 3);
    CHECK(sent(time, 0, 1).words == 3 * 10);
}

TEST_CASE("a smooth gradient takes 26 cycles more than central differences") {
    VolumeWork volume = volume_of(4, 4, {4, 4, 4});
    const Ns central = simulate(machine_of(1), {{volume}, {}}).steps[0].end;
    volume.gradient = GradientKernel::smooth;
    const Ns smooth = simulate(machine_of(1), {{volume}, {}}).steps[0].end;
    CHECK(smooth - central == 2 * (2 * 16 * 26 * 25));
}

TEST_CASE("each GP is sent the slices of its sets, each slice once") {
    // Slab s has slices s - 1 .. s + 2. Four slabs on four GPs: 3, 4, 4 and 3 slices.
    const VolumeWork volume = volume_of(4, 4, {4, 4, 4, 4, 4});
    RunTime time = simulate(machine_of(4), {{volume}, {}});
    CHECK(sent(time, 0, 1).packets == 3);
    CHECK(sent(time, 0, 2).packets == 4);
    CHECK(sent(time, 0, 3).packets == 4);
    CHECK(sent(time, 0, 4).packets == 3);
    // On three, GP 0 has slabs 0 and 3: all slices, though slices 1 and 2 belong to both sets... of
    // which slice 2 alone is in both: 0..2 and 2..4.
    time = simulate(machine_of(3), {{volume}, {}});
    CHECK(sent(time, 0, 1).packets == 5);
    CHECK(sent(time, 0, 2).packets == 4);
    CHECK(sent(time, 0, 3).packets == 4);
}

TEST_CASE("a single slice has no slab, and nothing to load") {
    const RunTime time = simulate(machine_of(2), {{volume_of(4, 4, {4})}, {}});
    CHECK(time.steps[0].end == 0);
    CHECK(time.ring.empty());
}

TEST_CASE("edges that are looked at: between runs along x, all along y and z") {
    const VolumeWork volume = volume_of(4, 3, {5, 7, 6});
    CHECK(edges_of(volume, 0) == (5 - 3) + 4 * 2 + 4 * 3 + (7 - 3) + 4 * 2);
    CHECK(edges_of(volume, 1) == (7 - 3) + 4 * 2 + 4 * 3 + (6 - 3) + 4 * 2);
    // Without two equal neighbors, all edges of each slab's grid of two slices.
    const VolumeWork noise = volume_of(5, 4, {20, 20, 20, 20, 20, 20});
    std::uint64_t all = 0;
    for (std::uint32_t slab = 0; slab < 5; ++slab) {
        all += edges_of(noise, slab);
    }
    CHECK(all == 5 * (2 * 4 * 4 + 2 * 5 * 3 + 5 * 4));
}

TEST_CASE("a build on one GP is its edges and triangles, and two messages") {
    const VolumeWork volume = volume_of(4, 3, {5, 7, 6});
    BuildWork build;
    build.slabs = {{0, 3, 4, 6}, {1, 2, 3, 4}};
    const RunTime time = simulate(machine_of(1), {{volume, build}, {}});
    REQUIRE(time.steps.size() == 2);
    CHECK(time.steps[1].begin == time.steps[0].end);
    // 34 + 35 edges of 4 cycles and 10 triangles of 400; the answer has 8 words and 8 a slab.
    constexpr Ns asked = 100'000 + 8'000 + 10 * 50 + 50 + 10'000;
    constexpr Ns extraction = (69 * 4 + 10 * 400) * 25;
    CHECK(length(time.steps[1]) == asked + extraction + to_host(8 + 2 * 8, 19));
    CHECK(use_of(time.steps[1].use, Unit::gp).busiest ==
          doctest::Approx(static_cast<double>(extraction + 20'000) /
                          static_cast<double>(length(time.steps[1]))));
}

TEST_CASE("a host with slow software limits a build") {
    Machine machine = machine_of(8);
    machine.host_message_us = 10'000;
    BuildWork build;
    build.slabs = {{0, 3, 4, 6}, {1, 2, 3, 4}};
    const RunTime time = simulate(machine, {{volume_of(4, 3, {5, 7, 6}), build}, {}});
    // SetSurface to each GP, and each one's answer.
    const UnitUse& host = use_of(time.steps[1].use, Unit::host);
    CHECK(host.busiest ==
          doctest::Approx(2 * 8 * 10e6 / static_cast<double>(length(time.steps[1]))));
    CHECK(host.mean == host.busiest);
    CHECK(time.steps[1].limit == Unit::host);
    CHECK(name_of(time.steps[1].limit) == "host");
}

TEST_CASE("a build's triangles are spread over the GPs, 20 words each") {
    const VolumeWork volume = volume_of(4, 3, {5, 7, 6});
    BuildWork build;
    build.slabs = {{0, 3, 4, 10}, {1, 2, 3, 4}};
    SUBCASE("evenly: of 10 two GPs hand over 5, of 4 they hand over 2") {
        const RunTime time = simulate(machine_of(2), {{volume, build}, {}});
        CHECK(sent(time, 1, 2).words == 5 * 20 + 2);
        CHECK(sent(time, 2, 1).words == 2 * 20 + 2);
    }
    SUBCASE("what is left over goes round from the GP itself") {
        const RunTime time = simulate(machine_of(3), {{volume, build}, {}});
        CHECK(sent(time, 1, 2).words == 3 * 20 + 2);  // Of 10: 4, 3, 3.
        CHECK(sent(time, 1, 3).words == 3 * 20 + 2);
        CHECK(sent(time, 2, 3).words == 1 * 20 + 2);  // Of 4: 2, 1, 1.
        CHECK(sent(time, 2, 1).words == 1 * 20 + 2);
        CHECK(sent(time, 3, 1).packets == 0);
    }
    SUBCASE("not at all where each keeps its own") {
        const RunTime time = simulate(machine_of(2, Sharing::own), {{volume, build}, {}});
        CHECK(sent(time, 1, 2).packets == 0);
        CHECK(sent(time, 2, 1).packets == 0);
    }
}

TEST_CASE("a build waits for the slowest GP, and for what it hands over") {
    const VolumeWork volume = volume_of(4, 3, {3, 3, 3});
    BuildWork build;
    build.slabs = {{0, 0, 0, 1000}, {1, 0, 0, 0}};
    const auto took = [&](Sharing share) {
        return length(simulate(machine_of(2, share), {{volume, build}, {}}).steps[1]);
    };
    // GP 0 takes 1000 x 400 + 28 x 4 cycles; GP 1, asked 100 us later, is long done. Of own ones
    // GP 0 answers at once.
    constexpr Ns asked = 100'000 + 8'000 + 10 * 50 + 50 + 10'000;
    constexpr Ns extraction = (1000 * 400 + 28 * 4) * 25;
    CHECK(took(Sharing::own) == asked + extraction + to_host(16, 20));
    // Else GP 1 is the last to answer: it takes 500 triangles of 20 words, which are 10 packets,
    // and GP 0's own answer, of 18 words with its header, goes between two of these.
    constexpr Ns handed = 10'000 + (10'000 + 10 * 2 + 18) * 50 + 50 + 10'000;
    CHECK(took(Sharing::even) == asked + extraction + handed + to_host(16, 19));
}

}  // namespace pxpl5::host::timing
