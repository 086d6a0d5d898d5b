#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "tests/host/frame_buffer/scenario.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

TEST_CASE(
    "a frame is its regions in their places, cropped at the edges, one view below the other") {
    std::mt19937 random(seed());
    CAPTURE(seed());
    const std::array shapes = {Shape{256, 128, 1}, Shape{300, 200, 1}, Shape{1, 1, 1},
                               Shape{129, 127, 2}, Shape{512, 512, 2}};
    for (const Shape shape : shapes) {
        for (const int renderers : {1, 3}) {
            CAPTURE(shape.width);
            CAPTURE(renderers);
            const Scenario frame = random_scenario(random, 7, shape, renderers);
            FrameBufferBench bench(renderers);
            bench.take(master_gp, frame.begin());
            std::vector<int> order;
            for (int i = 0; i < renderers; ++i) {
                order.push_back(i);
            }
            std::shuffle(order.begin(), order.end(), random);
            for (const int i : order) {
                CHECK(bench.done().empty());
                bench.from_renderer(i, frame.pixels(i));
            }
            REQUIRE(bench.done() == std::vector<std::uint32_t>{7});
            CHECK(picture_of(bench.out.sent[0]) == frame.expected());
        }
    }
}

TEST_CASE("a finished frame says its size, its cycles by region and the sum of instructions") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 0, {300, 200, 2}, 3);
    FrameBufferBench bench(3);
    bench.take(master_gp, frame.begin(false));
    for (int i = 0; i < 3; ++i) {
        bench.from_renderer(i, frame.pixels(i));
    }
    REQUIRE(bench.out.sent.size() == 1);
    const schema::FrameDone& done = FrameBufferBench::frame_done(bench.out.sent[0]);
    CHECK(done.frame() == 0);
    CHECK(done.width() == 300);
    CHECK(done.height() == 200);
    CHECK(done.views() == 2);
    CHECK(std::vector<std::uint64_t>(done.region_cycles()->begin(), done.region_cycles()->end()) ==
          frame.cycles);
    CHECK(std::vector<std::uint16_t>(done.region_renderers()->begin(),
                                     done.region_renderers()->end()) == frame.assignment);
    std::uint64_t cycles = 0;
    for (const std::uint64_t c : frame.cycles) {
        cycles += c;
    }
    CHECK(done.instructions() == 3 * cycles);
    CHECK_MESSAGE(done.pixels() == nullptr, "pixels travel only when asked for");
}

TEST_CASE("regions may overtake their BeginFrame, and two frames may interleave") {
    std::mt19937 random(seed());
    const Scenario first = random_scenario(random, 4, {300, 200, 1}, 2);
    const Scenario second = random_scenario(random, 6, {130, 129, 2}, 2);
    FrameBufferBench bench(2);
    bench.from_renderer(1, first.pixels(1));
    bench.from_renderer(1, second.pixels(1));
    bench.take(master_gp, first.begin());
    bench.take(master_gp, second.begin());
    CHECK(bench.done().empty());
    bench.from_renderer(0, first.pixels(0));
    CHECK(bench.done() == std::vector<std::uint32_t>{4});
    bench.from_renderer(0, second.pixels(0));
    REQUIRE(bench.done() == std::vector<std::uint32_t>{4, 6});
    CHECK(picture_of(bench.out.sent[0]) == first.expected());
    CHECK(picture_of(bench.out.sent[1]) == second.expected());
}

TEST_CASE("a frame is finished at its BeginFrame if all its regions overtook it") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 1, {200, 100, 1}, 2);
    FrameBufferBench bench(2);
    bench.from_renderer(0, frame.pixels(0));
    bench.from_renderer(1, frame.pixels(1));
    bench.take(master_gp, frame.begin());
    REQUIRE(bench.done() == std::vector<std::uint32_t>{1});
    CHECK(picture_of(bench.out.sent[0]) == frame.expected());
}

TEST_CASE("many frames of changing size, in any arrival order, are each right") {
    std::mt19937 random(seed());
    CAPTURE(seed());
    constexpr int renderers = 4;
    FrameBufferBench bench(renderers);
    for (std::uint32_t k = 0; k < 20; k += 2) {
        std::array<Scenario, 2> pair;
        for (std::uint32_t i = 0; i < 2; ++i) {
            const Shape shape{1 + static_cast<int>(random() % 300),
                              1 + static_cast<int>(random() % 300),
                              1 + static_cast<int>(random() % 2)};
            pair[i] = random_scenario(random, k + i, shape, renderers);
        }
        // Each sender's own messages stay in order; between senders anything goes.
        std::vector<int> senders;
        for (int sender = 0; sender <= renderers; ++sender) {
            senders.insert(senders.end(), {sender, sender});
        }
        std::shuffle(senders.begin(), senders.end(), random);
        std::array<std::size_t, renderers + 1> sent{};
        for (const int sender : senders) {
            const Scenario& frame = pair[sent[static_cast<std::size_t>(sender)]++];
            if (sender == renderers) {
                bench.take(master_gp, frame.begin());
            } else {
                bench.from_renderer(sender, frame.pixels(sender));
            }
        }
        REQUIRE(bench.out.sent.size() == k + 2);
        CHECK(picture_of(bench.out.sent[k]) == pair[0].expected());
        CHECK(picture_of(bench.out.sent[k + 1]) == pair[1].expected());
    }
}

TEST_CASE("a frame that a Renderer failed to send does not hold up the next") {
    std::mt19937 random(seed());
    const Scenario lost = random_scenario(random, 1, {200, 100, 1}, 2);
    const Scenario next = random_scenario(random, 2, {200, 100, 1}, 2);
    FrameBufferBench bench(2);
    bench.take(master_gp, lost.begin());
    bench.from_renderer(0, lost.pixels(0));
    bench.take(master_gp, next.begin());
    bench.from_renderer(0, next.pixels(0));
    CHECK(bench.done().empty());
    bench.from_renderer(1, next.pixels(1));
    REQUIRE(bench.done() == std::vector<std::uint32_t>{2});
    CHECK(picture_of(bench.out.sent[0]) == next.expected());
    const std::string late = bench.fault(first_renderer + 1, lost.pixels(1));
    CHECK_MESSAGE(late == "frame 1, Renderer 1: its regions come late, the frame is over", late);
}

TEST_CASE("regions that do not belong are named faults, and the frame can still be finished") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 3, {300, 300, 1}, 2);
    FrameBufferBench bench(2);
    bench.take(master_gp, frame.begin());

    const auto refused = [&](const schema::RegionPixelsT& tiles, bus::NodeId source,
                             const std::string& reason) {
        const std::string fault = bench.fault(source, bus::pack(tiles));
        CHECK_MESSAGE(fault == reason, fault);
    };
    const auto edited = [&](auto edit) {
        schema::RegionPixelsT tiles = frame.tiles(0);
        REQUIRE(tiles.tiles.size() >= 2);
        edit(tiles);
        return tiles;
    };
    const auto mine = std::to_string(frame.tiles(0).tiles[0].region());
    const auto other = std::to_string(frame.tiles(1).tiles[0].region());
    const auto count = frame.tiles(0).tiles.size();

    refused(edited([](auto& t) { t.tiles[0].mutate_region(9); }), first_renderer,
            "frame 3, Renderer 0: region 9, the frame has 9");
    refused(edited([&](auto& t) { t.tiles[0] = frame.tiles(1).tiles[0]; }), first_renderer,
            "frame 3, Renderer 0: region " + other + " is Renderer 1's");
    refused(edited([](auto& t) { t.tiles[1] = t.tiles[0]; }), first_renderer,
            "frame 3, Renderer 0: region " + mine + " came twice");
    refused(edited([](auto& t) {
                t.tiles.pop_back();
                t.pixels.resize(t.pixels.size() - side * side);
            }),
            first_renderer,
            "frame 3, Renderer 0: " + std::to_string(count - 1) + " regions, " +
                std::to_string(count) + " are assigned to it");
    refused(frame.tiles(0), first_renderer + 1,
            "frame 3: node 11 sends regions as Renderer 0, of 2 Renderers");
    refused(edited([](auto& t) { t.renderer = 2; }), first_renderer,
            "frame 3: node 10 sends regions as Renderer 2, of 2 Renderers");

    bench.from_renderer(0, frame.pixels(0));
    refused(frame.tiles(0), first_renderer, "frame 3, Renderer 0: its regions came twice");
    bench.from_renderer(1, frame.pixels(1));
    REQUIRE(bench.done() == std::vector<std::uint32_t>{3});
    CHECK(picture_of(bench.out.sent[0]) == frame.expected());
    refused(frame.tiles(0), first_renderer,
            "frame 3, Renderer 0: its regions come late, the frame is over");
}

TEST_CASE("a BeginFrame that makes no sense is a named fault") {
    std::mt19937 random(seed());
    const Scenario frame = random_scenario(random, 3, {300, 300, 1}, 2);
    FrameBufferBench bench(2);
    const auto refused = [&](auto edit, const std::string& reason) {
        Scenario bad = frame;
        edit(bad);
        const std::string fault = bench.fault(master_gp, bad.begin());
        CHECK_MESSAGE(has(fault, reason), fault);
    };
    refused([](Scenario& s) { s.assignment[4] = 2; },
            "region 4 is assigned to Renderer 2, there are 2");
    bench.take(master_gp, frame.begin());
    CHECK(has(bench.fault(master_gp, frame.begin()), "frame 3 begins after frame 3"));
    CHECK(has(bench.fault(bus::host_id, bus::pack(schema::SetSurfaceT{})),
              "a frame buffer does not take SetSurface"));
}

TEST_CASE("regions of frames that never begin are refused once their number is out of bounds") {
    std::mt19937 random(seed());
    FrameBufferBench bench(1);
    std::string fault = "no fault";
    int held = 0;
    for (; held < 100 && fault == "no fault"; ++held) {
        const Scenario frame =
            random_scenario(random, static_cast<std::uint32_t>(held), {8, 8, 1}, 1);
        fault = bench.fault(first_renderer, frame.pixels(0));
    }
    CHECK(held < 100);
    CHECK_MESSAGE(has(fault, "the frame is unknown"), fault);
}

TEST_CASE("depths come in the picture's order, words as they are, if they are asked for") {
    std::mt19937 random(seed());
    for (const bool wanted : {true, false, true}) {
        Scenario frame = random_scenario(random, 3, {300, 200, 2}, 3);
        frame.read_depths = wanted;
        FrameBufferBench bench(3);
        bench.take(master_gp, frame.begin());
        for (int i = 0; i < 3; ++i) {
            bench.from_renderer(i, frame.pixels(i));
        }
        REQUIRE(bench.out.sent.size() == 1);
        CHECK(picture_of(bench.out.sent[0]) == frame.expected());
        const auto* depths = FrameBufferBench::frame_done(bench.out.sent[0]).depths();
        REQUIRE((depths != nullptr) == wanted);
        if (wanted) {
            CHECK(std::vector<std::uint32_t>(depths->begin(), depths->end()) ==
                  frame.expected_depths());
        }
    }
}

TEST_CASE("depths that are missing, or that nobody asked for, are refused by name") {
    std::mt19937 random(seed());
    Scenario frame = random_scenario(random, 3, {300, 200, 1}, 1);
    for (const bool wanted : {true, false}) {
        FrameBufferBench bench(1);
        frame.read_depths = wanted;
        bench.take(master_gp, frame.begin());
        frame.read_depths = !wanted;
        CHECK(bench.fault(first_renderer, frame.pixels(0)) ==
              (wanted ? "frame 3, Renderer 0: it sends no depths, the frame wants them"
                      : "frame 3, Renderer 0: it sends depths, the frame wants none"));
    }
}

TEST_CASE("a frame that cannot be sent is a fault, and the next one is shown") {
    std::mt19937 random(seed());
    CAPTURE(seed());
    const Scenario lost = random_scenario(random, 1, {300, 200, 1}, 1);
    const Scenario next = random_scenario(random, 2, {300, 200, 1}, 1);
    FrameBufferBench bench(1);
    bench.take(master_gp, lost.begin());
    bench.out.is_full = true;
    CHECK(bench.fault(first_renderer, lost.pixels(0)) == "the host is full");

    bench.out.is_full = false;
    CHECK(bench.fault(first_renderer, lost.pixels(0)).find("the frame is over") !=
          std::string::npos);
    bench.take(master_gp, next.begin());
    bench.from_renderer(0, next.pixels(0));
    REQUIRE(bench.done() == std::vector<std::uint32_t>{2});
    CHECK(picture_of(bench.out.sent[0]) == next.expected());
}

TEST_CASE("a pass that is not its picture's last is finished by regions without pixels") {
    std::mt19937 random(seed());
    Scenario frame = random_scenario(random, 3, {300, 200, 1}, 1);
    frame.samples = 4;
    schema::RegionPixelsT bare = frame.tiles(0);
    bare.pixels.clear();
    const bus::Payload with_pixels = frame.pixels(0), without = bus::pack(bare);
    FrameBufferBench bench(1);
    bench.take(master_gp, frame.begin(false));
    CHECK(bench.fault(first_renderer, with_pixels) ==
          "frame 3, Renderer 0: it sends pixels, the frame has none");
    bench.from_renderer(0, without);
    CHECK(bench.done() == std::vector<std::uint32_t>{3});

    frame.sample = 3;
    FrameBufferBench last(1);
    last.take(master_gp, frame.begin());
    CHECK(last.fault(first_renderer, without) ==
          "frame 3, Renderer 0: it sends no pixels, the frame has them");
    last.from_renderer(0, with_pixels);
    REQUIRE(last.done() == std::vector<std::uint32_t>{3});
    CHECK(picture_of(last.out.sent[0]) == frame.expected());
}

TEST_CASE("each of two frame buffers assembles its own eye, and one alone a frame of one view") {
    std::mt19937 random(seed());
    CAPTURE(seed());
    Scenario pair = random_scenario(random, 4, {300, 200, 2}, 3);
    pair.read_depths = true;
    const Scenario mono = random_scenario(random, 5, {130, 60, 1}, 3);
    const std::vector<std::uint32_t> whole = pair.expected(), depths = pair.expected_depths();
    const std::ptrdiff_t half = std::ptrdiff_t{300} * 200;
    for (const int eye : {0, 1}) {
        CAPTURE(eye);
        const FrameBufferPlace place{eye, 2};
        FrameBufferBench bench(3, place);
        bench.take(master_gp, pair.begin());
        for (int i = 0; i < 3; ++i) {
            CHECK(bench.done().empty());
            bench.from_renderer(i, pair.pixels(i, place));
        }
        REQUIRE(bench.done() == std::vector<std::uint32_t>{4});
        const schema::FrameDone& done = FrameBufferBench::frame_done(bench.out.sent[0]);
        CHECK(done.views() == 1);
        CHECK(picture_of(bench.out.sent[0]) ==
              std::vector<std::uint32_t>(whole.begin() + eye * half,
                                         whole.begin() + (eye + 1) * half));
        CHECK(std::vector<std::uint32_t>(done.depths()->begin(), done.depths()->end()) ==
              std::vector<std::uint32_t>(depths.begin() + eye * half,
                                         depths.begin() + (eye + 1) * half));
        const auto at = pair.cycles.begin() + eye * 6;  // 3 x 2 regions of each view.
        CHECK(std::vector<std::uint64_t>(done.region_cycles()->begin(),
                                         done.region_cycles()->end()) ==
              std::vector<std::uint64_t>(at, at + 6));
        const auto by = pair.assignment.begin() + eye * 6;
        CHECK(std::vector<std::uint16_t>(done.region_renderers()->begin(),
                                         done.region_renderers()->end()) ==
              std::vector<std::uint16_t>(by, by + 6));
        CHECK(done.instructions() == 3 * std::accumulate(at, at + 6, std::uint64_t{0}));

        bench.take(master_gp, mono.begin());
        for (int i = 0; i < 3; ++i) {
            const std::string fault =
                bench.fault(static_cast<bus::NodeId>(first_renderer + i), mono.pixels(i));
            CHECK_MESSAGE(has(fault, eye == 0 ? "no fault" : "the frame is over"), fault);
        }
        REQUIRE(bench.out.sent.size() == (eye == 0 ? 2 : 1));
        CHECK(bench.node.status().queue == 0);
    }
}

TEST_CASE("a region of the other eye's view is refused by its number, and so is a strange place") {
    std::mt19937 random(seed());
    Scenario pair = random_scenario(random, 4, {100, 60, 2}, 1);
    FrameBufferBench bench(1, {1, 2});
    bench.take(master_gp, pair.begin());
    CHECK(
        bench.fault(first_renderer, pair.pixels(0, {0, 2})) ==
        "frame 4, Renderer 0: region 0 belongs to a view of another frame buffer, this is 1 of 2");
    bench.from_renderer(0, pair.pixels(0, {1, 2}));
    CHECK(bench.done() == std::vector<std::uint32_t>{4});

    schema::TopologyT topology;
    topology.nodes.push_back(std::make_unique<schema::NodeInfoT>());
    CHECK(bench.fault(bus::host_id, bus::pack(topology)) ==
          "topology: node 99 is not one of the 0 frame buffers");
    Scenario next = random_scenario(random, 5, {100, 60, 2}, 1);  // As if the message had not come.
    bench.take(master_gp, next.begin());
    bench.from_renderer(0, next.pixels(0, {1, 2}));
    CHECK(bench.done() == std::vector<std::uint32_t>{4, 5});
}
