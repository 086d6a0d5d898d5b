// Frames on machines of several nodes: who draws what, what overlaps, what is conserved.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "host/timing/replay/frame_plan.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

using namespace testing;

namespace {

Machine machine_of(std::uint32_t gps, std::uint32_t renderers) {
    Machine machine = round_machine();
    machine.gps = gps;
    machine.renderers = renderers;
    machine.assignment = Assignment::round_robin;
    return machine;
}

FrameWork pass_of(FrameWork frame) {
    frame.reads_out = false;
    return frame;
}

/// Words from places first..end to places of a second range, and their packets' headers.
std::uint64_t words_between(const RunTime& time, std::array<std::size_t, 2> from,
                            std::array<std::size_t, 2> to) {
    std::uint64_t words = 0;
    for (const RingCount& count : time.ring) {
        if (count.source >= from[0] && count.source < from[1] && count.destination >= to[0] &&
            count.destination < to[1]) {
            words += count.words;
        }
    }
    return words;
}

Ns length(const StepTime& step) {
    return step.end - step.begin;
}

const UnitUse& use_of(const StepTime& step, Unit unit) {
    return testing::use_of(step.use, unit);
}

/// Busy time of all nodes of a kind together.
double busy(const StepTime& step, Unit unit, std::uint32_t nodes) {
    return use_of(step, unit).mean * nodes * static_cast<double>(length(step));
}

}  // namespace

TEST_CASE("a free Renderer takes the next region, or in turn each takes its own") {
    Machine machine = machine_of(1, 2);
    // Region 0 has many primitives, regions 1 to 3 have one each.
    FrameWork frame = frame_of(512, 128, 4, 1);
    for (PartWork& part : frame.parts) {
        if (part.kind == PartKind::segment && part.region == 0) {
            part = segment(0, 0, 20'000);
        }
    }
    // One bin is one message: words and 2 a packet. Places: host, GP, Renderers 2 and 3.
    constexpr std::uint64_t small = 34 + 2, large = 20'000 * 34 + 665 * 2;
    constexpr std::uint64_t begin = 66, assigned = 4;
    const auto taken_by = [](const RunTime& time, std::size_t place) {
        return words_between(time, {1, 2}, {place, place + 1});
    };
    const RunTime in_turn = simulate(machine, {{frame}, {}});
    CHECK(taken_by(in_turn, 2) == begin + large + small);
    CHECK(taken_by(in_turn, 3) == begin + 2 * small);
    machine.assignment = Assignment::first_free;
    const RunTime first_free = simulate(machine, {{frame}, {}});
    // Whoever ends first is answered although the frame has no region left: not before the next.
    CHECK(taken_by(first_free, 2) == begin + large + assigned);
    CHECK(taken_by(first_free, 3) == begin + 3 * small + 3 * assigned);
    CHECK(length(first_free.steps[0]) <= length(in_turn.steps[0]));
    machine.assignment = Assignment::recorded;
    frame.assignment = {1, 1, 0, 1};
    CHECK(taken_by(simulate(machine, {{frame}, {}}), 2) == begin + small);
}

TEST_CASE("longest first, the newest drawn frame's dearest regions are handed out first") {
    using Order = std::vector<std::uint32_t>;
    const std::vector<std::uint64_t> costs = {5, 9, 9, 1};
    CHECK(order_of(Assignment::longest_first, 4, costs) == Order{1, 2, 0, 3});
    CHECK(order_of(Assignment::first_free, 4, costs) == Order{0, 1, 2, 3});
    CHECK(order_of(Assignment::longest_first, 3, costs) == Order{0, 1, 2});  // Another size.
    CHECK(order_of(Assignment::longest_first, 4, {}) == Order{0, 1, 2, 3});

    Machine machine = machine_of(1, 2);
    FrameWork frame = frame_of(512, 128, 4, 1);
    for (PartWork& part : frame.parts) {
        if (part.kind == PartKind::segment) {
            part = segment(part.region, 0, part.region == 3 ? 30'000 : 10'000);
        }
    }
    machine.assignment = Assignment::first_free;
    const RunTime by_number = simulate(machine, {{frame, frame}, {}});
    machine.assignment = Assignment::longest_first;
    const RunTime longest = simulate(machine, {{frame, frame}, {}});
    CHECK(length(longest.steps[0]) == length(by_number.steps[0]));  // Nothing is known yet.
    // By number one Renderer works for 1 + 3, the other for 1 + 1; longest first both for 3.
    CHECK(length(longest.steps[1]) < length(by_number.steps[1]));
}

TEST_CASE("spread evenly, a slab's primitives are everybody's, and else its GP's alone") {
    Machine machine = machine_of(4, 1);
    const FrameWork frame = pass_of(frame_of(128, 128, 1, 400));
    const RunTime even = simulate(machine, {{frame}, {}});
    machine.share = Sharing::own;
    const RunTime own = simulate(machine, {{frame}, {}});
    constexpr double draw = 400 * (1000 + 34 * 10) * 25.0;
    // The Master's messages: DrawFrame, a region begun, BeginFrame to 3 GPs, a Renderer, a frame
    // buffer; its bin.
    constexpr double master = 10'000 + 40 * 25 + 5 * 10'000 + 10'000;
    CHECK(use_of(own.steps[0], Unit::gp).index == 0);
    const auto time = [](const RunTime& of) { return static_cast<double>(length(of.steps[0])); };
    CHECK(use_of(own.steps[0], Unit::gp).busiest * time(own) == doctest::Approx(draw + master));
    CHECK(use_of(even.steps[0], Unit::gp).busiest * time(even) ==
          doctest::Approx(draw / 4 + master));
    // In all: as much drawing, BeginFrame taken three times, and one bin or four.
    CHECK(busy(own.steps[0], Unit::gp, 4) == doctest::Approx(draw + master + 3 * 10'000));
    CHECK(busy(even.steps[0], Unit::gp, 4) == doctest::Approx(draw + master + 6 * 10'000));
    // A Renderer works as long either way.
    CHECK(busy(own.steps[0], Unit::renderer, 1) ==
          doctest::Approx(busy(even.steps[0], Unit::renderer, 1)));
}

TEST_CASE("primitives of other slabs are other GPs'") {
    Machine machine = machine_of(2, 1);
    machine.share = Sharing::own;
    const RunTime time = simulate(machine, {{frame_of(128, 128, 3, 10)}, {}});
    // Slabs 0 and 2 are GP 0's, slab 1 GP 1's; GP 0 also begins the frame.
    CHECK(words_between(time, {1, 2}, {3, 4}) == 66 + 2 * 340 + 2);
    CHECK(words_between(time, {2, 3}, {3, 4}) == 340 + 2);
}

TEST_CASE("a GP draws its own slabs, not another's") {
    Machine machine = machine_of(2, 1);
    machine.share = Sharing::own;
    FrameWork frame = pass_of(frame_of(128, 128, 2, 400));
    frame.drawn[0].primitives = 0;
    std::erase_if(frame.parts,
                  [](const PartWork& p) { return p.kind == PartKind::segment && p.slab == 0; });
    const RunTime time = simulate(machine, {{frame}, {}});
    const UnitUse& use = use_of(time.steps[0], Unit::gp);
    CHECK(use.index == 1);
    // BeginFrame taken, slab 1's primitives and words, its bin sent.
    CHECK(use.busiest * static_cast<double>(length(time.steps[0])) ==
          doctest::Approx(10'000 + 400 * (1000 + 34 * 10) * 25.0 + 10'000));
}

TEST_CASE("what is drawn travels once, and what was drawn is read out once") {
    for (const std::uint32_t gps : {1U, 5U, 36U}) {
        Machine machine = machine_of(gps, 3);
        machine.ring_header_words = 0;
        machine.assignment = Assignment::first_free;
        const FrameWork frame = frame_of(640, 512, 55, 77);
        const RunTime time = simulate(machine, {{frame, frame}, {}});
        const std::size_t renderers = 1 + gps, ports = renderers + 3;
        // BeginFrame, a region's assignment, segments; each frame.
        CHECK(words_between(time, {1, renderers}, {renderers, ports}) ==
              2 * (3 * 64 + 20 * 2 + 55 * 77 * 34));
        // Asked for: one region behind each.
        CHECK(words_between(time, {renderers, ports}, {1, 2}) == 2 * 20 * 2);
        CHECK(words_between(time, {renderers, ports}, {ports, ports + 2}) == 2 * 20 * 128 * 128);
        // Ports take turns by region.
        CHECK(words_between(time, {renderers, ports}, {ports, ports + 1}) == 2 * 10 * 128 * 128);
        // Renderers work for every primitive, prologue, end and port... which overlap other work.
        const double work = 55 * 77 * 232 * 25 + 20 * (200 + 4000) * 25;
        const double both = busy(time.steps[0], Unit::renderer, 3);
        CHECK(both >= work);
        CHECK(both <= work + 20 * 16'000 * 25);
    }
}

TEST_CASE("pixels leave while the next region is drawn, one region at a time") {
    constexpr std::uint32_t regions = 6;
    const FrameWork frame = pass_of(frame_of(128 * regions, 128, 6, 10));
    const FrameWork first = pass_of(frame_of(128, 128, 1, 10));
    Machine machine = machine_of(1, 1);
    // So quick that all bins are there when the Renderer comes to them.
    machine.gp_message_us = 0;
    machine.gp_draw_primitive_cycles = machine.gp_emit_word_cycles = 0;
    machine.master_region_cycles = 0;
    machine.ring_hop_ns = 0;
    const Ns one = length(simulate(machine, {{first}, {}}).steps[0]);
    const Ns all = length(simulate(machine, {{frame}, {}}).steps[0]);
    // Drawing takes 10 x 232 + 4200 cycles, the port 16,000, and then 3 words leave.
    CHECK(all - one == (regions - 1) * (16'000 * 25 + 3 * 50));
    // A port that takes no time leaves drawing alone: 163 us a region.
    FrameWork quick = frame;
    FrameWork quick_first = first;
    for (FrameWork* of : {&quick, &quick_first}) {
        for (PartWork& part : of->parts) {
            if (part.kind == PartKind::end_of_region) {
                part.classes[0].cycles -= part.port_cycles;
                part.port_cycles = 0;
            }
        }
    }
    CHECK(length(simulate(machine, {{quick}, {}}).steps[0]) -
              length(simulate(machine, {{quick_first}, {}}).steps[0]) ==
          (regions - 1) * (10 * 232 + 4200) * 25);
}

TEST_CASE("a surface's doors open once, whoever brings its first packet") {
    FrameWork frame = pass_of(frame_of(128, 128, 1, 36));
    const auto took = [&] { return length(simulate(machine_of(4, 1), {{frame}, {}}).steps[0]); };
    const Ns without = took();
    PartWork shut = part(0, PartKind::shut_door, 700), open = part(0, PartKind::open_door, 300);
    frame.parts.insert(frame.parts.begin() + 1, shut);
    frame.parts.insert(frame.parts.end() - 1, open);
    // The first packet is worked that much later; others come in the meantime, and wait.
    const Ns with = took();
    CHECK(with > without);
    CHECK(with <= without + 1000 * 25);
    // With one GP there is one packet: all of it shows.
    const auto alone = [&] { return length(simulate(machine_of(1, 1), {{frame}, {}}).steps[0]); };
    const Ns with_alone = alone();
    std::erase_if(frame.parts, [](const PartWork& p) {
        return p.kind == PartKind::shut_door || p.kind == PartKind::open_door;
    });
    CHECK(with_alone == alone() + 1000 * 25);
}

TEST_CASE("depths that are read out are as many words again") {
    FrameWork frame = frame_of(128, 128, 1, 1);
    PartWork depths = part(0, PartKind::depths, 16'416);
    depths.port_cycles = 16'416;
    frame.parts.insert(frame.parts.end() - 1, depths);
    const RunTime time = simulate(machine_of(1, 1), {{frame}, {}});
    CHECK(words_between(time, {2, 3}, {3, 5}) == 2 * 16 * (1024 + 2));
}

TEST_CASE("two eyes go to two frame buffers, which swap together") {
    Machine machine = machine_of(1, 2);
    machine.frame_buffers = 2;
    FrameWork frame = frame_of(128, 128, 2, 5);
    frame.views = 2;
    frame.parts.push_back(segment(1, 1, 5));
    const RunTime time = simulate(machine, {{frame}, {}});
    // Ports of 2 frame buffers: places 4, 5 and 6, 7. Region 1 is view 1.
    CHECK(words_between(time, {2, 4}, {4, 5}) == 16 * 1026);
    CHECK(words_between(time, {2, 4}, {7, 8}) == 16 * 1026);
    // Each reports its view to the host.
    CHECK(words_between(time, {4, 5}, {0, 1}) == 6);
    CHECK(words_between(time, {6, 7}, {0, 1}) == 6);
    frame.views = 1;
    frame.width = 256;
    const RunTime mono = simulate(machine, {{frame}, {}});
    CHECK(words_between(mono, {4, 5}, {0, 1}) == 6);
    CHECK(words_between(mono, {6, 7}, {0, 1}) == 0);
}

TEST_CASE("frames overlap as far as they may be under way") {
    Machine machine = machine_of(4, 2);
    const FrameWork frame = frame_of(256, 128, 8, 500);
    const RunWork run{{frame, frame, frame}, {}};
    const RunTime one = simulate(machine, run);
    machine.frames_in_flight = 2;
    const RunTime two = simulate(machine, run);
    // The host's knowledge comes after what is shown; 4 words go through ring, link and software.
    CHECK(one.steps[1].begin > one.steps[0].end);
    CHECK(one.steps[2].begin > one.steps[1].end);
    CHECK(two.steps[1].begin == 0);
    CHECK(two.steps[2].begin > two.steps[0].end);
    CHECK(two.steps[2].begin < two.steps[1].end);
    CHECK(two.steps[2].end < one.steps[2].end);
    // Every frame is shown at a retrace of its own.
    for (const StepTime& step : two.steps) {
        CHECK(step.end % 20'000'000 == 0);
    }
    CHECK(two.steps[1].end > two.steps[0].end);
}

TEST_CASE("a frame is not shown before the one before, however little it has") {
    Machine machine = machine_of(2, 2);
    machine.frames_in_flight = 3;
    const RunTime time = simulate(
        machine,
        {{frame_of(256, 128, 2, 5000), frame_of(128, 128, 1, 1), frame_of(128, 128, 1, 1)}, {}});
    CHECK(time.steps[0].end < time.steps[1].end);
    CHECK(time.steps[1].end < time.steps[2].end);
}

TEST_CASE("the same run gives the same times, and earlier steps change nothing but when") {
    Machine machine = machine_of(5, 3);
    machine.assignment = Assignment::first_free;
    const FrameWork frame = pass_of(frame_of(640, 512, 55, 77));
    VolumeWork volume{"v", 8, 8, 8, 2, std::vector<std::uint64_t>(8, 20)};
    const RunTime first = simulate(machine, {{frame}, {}});
    const RunTime again = simulate(machine, {{frame}, {}});
    CHECK(first.events == again.events);
    CHECK(first.steps[0].end == again.steps[0].end);
    CHECK(std::ranges::equal(first.ring, again.ring, [](const RingCount& p, const RingCount& q) {
        return p.source == q.source && p.destination == q.destination && p.channel == q.channel &&
               p.messages == q.messages && p.words == q.words;
    }));
    const RunTime later = simulate(machine, {{volume, frame}, {}});
    CHECK(length(later.steps[1]) == length(first.steps[0]));
    CHECK(later.steps[1].begin == later.steps[0].end);
    for (std::size_t unit = 0; unit < first.steps[0].use.size(); ++unit) {
        CHECK(later.steps[1].use[unit].mean == doctest::Approx(first.steps[0].use[unit].mean));
    }
}

TEST_CASE("a GP that never waits sets the rate, whatever the retrace") {
    Machine machine = machine_of(1, 1);
    machine.frames_in_flight = 2;
    const FrameWork frame = frame_of(128, 128, 1, 1000);
    // A frame is 33.5 ms of drawing; DrawFrame, a region begun, two times BeginFrame and a bin.
    // Everything behind the bin takes 5.8 ms of triangles, 1.3 ms, and at most 20 ms for a retrace.
    constexpr double period = 1000 * (1000 + 340) * 25.0 + 10'000 + 1'000 + 2 * 10'000 + 10'000;
    const Rate rate = frame_rate(machine, frame);
    // A command may come before the bin leaves or behind it: once in 12 frames, 31 us.
    CHECK(rate.frames_per_s == doctest::Approx(1e9 / period).epsilon(31e3 / (12 * period)));
    CHECK(rate.limit == Unit::gp);
    CHECK(use_of(rate.use, Unit::gp).busiest == doctest::Approx(1).epsilon(1e-4));
}

TEST_CASE("the busiest unit is the limit from 90 % of the time on, else waiting is") {
    std::vector<UnitUse> use = {
        {Unit::host, 0, 0.2, 0}, {Unit::gp, 0.1, 0.9, 3}, {Unit::ring, 0.8, 0.8, 0}};
    CHECK(busiest_of(use).unit == Unit::gp);
    CHECK(limit_of(use) == Unit::gp);
    use[1].busiest = 0.899;
    CHECK(busiest_of(use).unit == Unit::gp);
    CHECK(limit_of(use) == Unit::waiting);
    CHECK(name_of(Unit::waiting) == "waiting");
}

TEST_CASE("one frame at a time keeps step with the retrace") {
    // All is over 1.3 ms after the command, so that every retrace but the one it waits for is free:
    // the host knows 0.1 ms behind a retrace and asks for the next.
    const Rate rate = frame_rate(machine_of(1, 1), frame_of(128, 128, 1, 2));
    CHECK(rate.frames_per_s == doctest::Approx(50.0).epsilon(1e-9));
    // FrameDone takes 6 words and 2 hops, 4 words of the link, and the host's software; the command
    // was given that long after the retrace before.
    CHECK(rate.latency == 20'000'000);
}

}  // namespace pxpl5::host::timing
