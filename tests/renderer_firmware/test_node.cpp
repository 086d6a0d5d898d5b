// Tests the Renderer's node: frames, depths, transparent surfaces and refused messages.
#include <algorithm>
#include <string>

#include "tests/renderer_firmware/node_bench.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

TEST_CASE("a frame leaves as one message, with this Renderer's regions in ascending order") {
    RendererBench bench(1, 2, 1);
    bench.take(first_gp, begin(5, {1, 0, 1, 0}));
    bench.from_gp(0, programs(5, 0, {{2, {{0, 3, sheet(0, 5000)}}}}));
    bench.work();
    const auto frames = bench.frames();
    REQUIRE(frames.size() == 1);
    CHECK(bench.faults().empty());
    CHECK(frames[0]->frame() == 5);
    CHECK(frames[0]->renderer() == 1);
    REQUIRE(frames[0]->tiles()->size() == 2);
    REQUIRE(frames[0]->pixels()->size() == 2 * tile);
    CHECK(frames[0]->tiles()->Get(0)->region() == 0);
    CHECK(frames[0]->tiles()->Get(1)->region() == 2);
    CHECK(is_all(*frames[0], 0, background));
    CHECK(is_all(*frames[0], 1, colors[0]));
    // The sheet takes the ten instructions of a triangle, plus the shading of its pixels.
    CHECK(frames[0]->tiles()->Get(1)->instructions() >=
          frames[0]->tiles()->Get(0)->instructions() + 10);
    CHECK(frames[0]->tiles()->Get(1)->cycles() > frames[0]->tiles()->Get(0)->cycles());
}

TEST_CASE("depths leave only if they are asked for, beside the pixels of their tiles") {
    for (const bool wanted : {false, true}) {
        RendererBench bench(1, 2, 1);
        bench.take(first_gp, begin(5, {1, 0, 1}, {16, wanted}));
        bench.from_gp(0, programs(5, 0, {{2, {{0, 3, sheet(0, 5000)}, {1, 3, sheet(1, 4000)}}}}));
        bench.work();
        REQUIRE(bench.frames().size() == 1);
        const schema::RegionPixels& sent = *bench.frames()[0];
        CHECK(is_all(sent, 1, colors[1]));
        REQUIRE((sent.depths() != nullptr) == wanted);
        if (wanted) {
            // Region 0 shows the background only.
            CHECK(!sent.tiles()->Get(0)->has_depths());
            CHECK(sent.tiles()->Get(1)->has_depths());
            REQUIRE(sent.depths()->size() == tile);
            const auto* words = sent.depths()->data();
            CHECK(std::all_of(words, words + tile,
                              [](std::uint32_t w) { return w == (2 | 4000 << 8); }));
        }
    }
}

TEST_CASE("a transparent surface leaves pixels to what is behind it, whichever is drawn first") {
    RendererBench bench(1, 1, 0);
    bench.take(first_gp, begin(1, {0, 0}, {4, false}));
    bench.from_gp(0, programs(1, 0,
                              {{0, {{0, 3, sheet(0, 5000)}, {1, 3, sheet(1, 4000)}}},
                               {1, {{1, 3, sheet(1, 4000)}}}}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    const auto* words = bench.frames()[0]->pixels()->data();
    CHECK(std::count(words, words + tile, colors[1]) == tile / 4);
    CHECK(std::count(words, words + tile, colors[0]) == tile * 3 / 4);
    CHECK(std::count(words + tile, words + 2 * tile, colors[1]) == tile / 4);
    CHECK(std::count(words + tile, words + 2 * tile, background) == tile * 3 / 4);
}

TEST_CASE("a stream that reads out does not put the tiles out of step") {
    RendererBench bench(1, 1, 0);
    WordList words = sheet(0, 5000);
    words.push_back(isa::encode({isa::Op::pixels_to_fb, {0, 0, 32}}));
    bench.take(first_gp, begin(1, {0, 0}));
    bench.from_gp(0, programs(1, 0, {{0, {{0, 3, words}}}}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    REQUIRE(bench.frames()[0]->pixels()->size() == 2 * tile);
    CHECK(is_all(*bench.frames()[0], 0, colors[0]));
    CHECK(is_all(*bench.frames()[0], 1, background));
}

TEST_CASE("a Renderer without regions sends its frame all the same") {
    RendererBench bench(2, 2, 0);
    bench.take(first_gp, begin(0, {1, 1}));
    bench.from_gp(0, programs(0, 0, {}));
    bench.from_gp(1, programs(0, 1, {}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(bench.frames()[0]->tiles()->size() == 0);
    CHECK(bench.frames()[0]->pixels()->size() == 0);
}

TEST_CASE("nothing is drawn before the frame has begun and every GP has spoken") {
    RendererBench bench(2, 1, 0);
    bench.from_gp(1, programs(3, 1, {}));
    CHECK_FALSE(bench.node.work(bench.out));
    bench.take(first_gp, begin(3, {0}));
    CHECK_FALSE(bench.node.work(bench.out));
    bench.from_gp(0, programs(3, 0, {}));
    bench.work();
    CHECK(bench.frames().size() == 1);
    CHECK(bench.faults().empty());
}

TEST_CASE("the order in which GPs' messages arrive changes nothing, and slabs decide ties") {
    const bus::Payload messages[] = {
        begin(1, {0}), programs(1, 0, {{0, {{1, 0, sheet(1, 7000)}}}}),
        programs(1, 1, {{0, {{0, 5, sheet(0, 7000)}, {0, 7, sheet(1, 7000)}}}}),
        programs(1, 2, {{0, {{0, 6, sheet(1, 7000)}}}})};
    const int sources[] = {first_gp, first_gp, first_gp + 1, first_gp + 2};
    int order[] = {0, 1, 2, 3};
    do {
        RendererBench bench(3, 1, 0);
        for (const int i : order) {
            bench.take(sources[i], messages[i]);
            bench.node.work(bench.out);
        }
        bench.work();
        REQUIRE(bench.frames().size() == 1);
        REQUIRE(bench.faults().empty());
        CHECK(is_all(*bench.frames()[0], 0, colors[0]));
    } while (std::next_permutation(std::begin(order), std::end(order)));
}

TEST_CASE("messages of two frames may interleave, and frames leave in ascending order") {
    RendererBench bench(2, 1, 0);
    bench.from_gp(1, programs(8, 1, {}));
    bench.from_gp(1, programs(9, 1, {{0, {{0, 0, sheet(0, 900)}}}}));
    bench.from_gp(0, begin(8, {0}));
    bench.from_gp(0, programs(8, 0, {{0, {{1, 0, sheet(1, 900)}}}}));
    bench.from_gp(0, begin(9, {0}));
    bench.from_gp(0, programs(9, 0, {}));
    bench.work();
    const auto frames = bench.frames();
    REQUIRE(frames.size() == 2);
    CHECK(bench.faults().empty());
    CHECK(frames[0]->frame() == 8);
    CHECK(is_all(*frames[0], 0, colors[1]));
    CHECK(frames[1]->frame() == 9);
    CHECK(is_all(*frames[1], 0, colors[0]));
}

TEST_CASE("a bad stream is a fault that names its place, and the region is drawn without it") {
    RendererBench bench(2, 1, 0);
    WordList bad = sheet(0, 10);
    bad.push_back(0xEE112233);
    bench.from_gp(0, begin(4, {0}));
    bench.from_gp(0, programs(4, 0, {{0, {{0, 12, bad}}}}));
    bench.from_gp(1, programs(4, 1, {{0, {{1, 3, sheet(1, 4000)}}}}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(is_all(*bench.frames()[0], 0, colors[1]));
    REQUIRE(bench.faults().size() == 1);
    const std::string fault = bench.faults()[0];
    for (const char* part :
         {"bad_instruction", "frame 4", "GP 0", "region 0", "slab 12", "word 34"}) {
        CAPTURE(fault);
        CHECK(fault.find(part) != std::string::npos);
    }
    CHECK(bench.fault_messages()[0]->frame() == 4);
    CHECK(bench.fault_messages()[0]->request() ==
          static_cast<std::uint16_t>(bus::Body::RegionPrograms));
}

TEST_CASE("segments that do not belong are faults, and the frame is finished") {
    RendererBench bench(2, 2, 0);
    bench.from_gp(0, begin(4, {0, 1}));
    bench.from_gp(0, programs(4, 0, {{1, {}}, {7, {}}, {0, {{0, 1, sheet(0, 1000)}}}}));
    bench.from_gp(1, programs(4, 1, {{0, {{9, 0, sheet(1, 10)}, {0, 1, sheet(1, 10)}}}}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(is_all(*bench.frames()[0], 0, colors[0]));
    const std::vector<std::string> faults = bench.faults();
    REQUIRE(faults.size() == 4);
    const auto any = [&](const char* text) {
        return std::any_of(faults.begin(), faults.end(),
                           [&](const std::string& f) { return f.find(text) != std::string::npos; });
    };
    CHECK(any("region 1 is not this Renderer's"));
    CHECK(any("region 7 is not this Renderer's"));
    CHECK(any("surface 9, slab 0: the frame has 2 surfaces"));
    CHECK(any("surface 0, slab 1: GP 0 has already drawn this surface and slab"));
}

TEST_CASE("a flood of bad segments is cut short") {
    RendererBench bench(1, 1, 0);
    RegionWords flood{0, {}};
    for (std::uint32_t slab = 0; slab < 1000; ++slab) {
        flood.segments.push_back({0, slab, {0xFFFFFFFF}});
    }
    bench.from_gp(0, begin(0, {0}));
    bench.from_gp(0, programs(0, 0, {flood}));
    bench.work();
    CHECK(bench.frames().size() == 1);
    REQUIRE(bench.faults().size() == 16);
    CHECK(bench.faults().back().find("further faults are not reported") != std::string::npos);
}

TEST_CASE("messages that cannot be right are refused by name") {
    RendererBench bench(2, 1, 0);
    CHECK(bench.refused(first_gp, bus::pack(schema::GoT())).find("Go") != std::string::npos);
    CHECK(bench.refused(first_gp, programs(0, 1, {})).find("as GP 1") != std::string::npos);
    CHECK(bench.refused(first_gp, programs(0, 2, {})).find("as GP 2") != std::string::npos);
    bench.from_gp(0, programs(0, 0, {}));
    CHECK(bench.refused(first_gp, programs(0, 0, {})).find("arrived twice") != std::string::npos);
    bench.from_gp(0, begin(0, {0}));
    CHECK(bench.refused(first_gp, begin(0, {0})).find("BeginFrame arrived twice") !=
          std::string::npos);
    bench.from_gp(1, programs(0, 1, {}));
    bench.work();
    CHECK(bench.frames().size() == 1);
    CHECK(bench.refused(first_gp, programs(0, 0, {})).find("is already drawn") !=
          std::string::npos);
    for (std::uint32_t frame = 1; frame <= 4; ++frame) {
        bench.from_gp(0, begin(frame, {0}));
    }
    CHECK(bench.refused(first_gp, begin(9, {0})).find("the limit is 4") != std::string::npos);
}

TEST_CASE("a frame that lost a message is given up, by name, when a later one is complete") {
    RendererBench bench(2, 1, 0);
    bench.from_gp(0, begin(1, {0}));
    bench.from_gp(0, programs(1, 0, {}));
    bench.from_gp(0, begin(2, {0}));
    bench.from_gp(0, programs(2, 0, {}));
    bench.from_gp(1, programs(2, 1, {}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(bench.frames()[0]->frame() == 2);
    REQUIRE(bench.faults().size() == 1);
    CHECK(bench.faults()[0].find("frame 1 is dropped") != std::string::npos);
    CHECK(bench.faults()[0].find("1 of 2 GPs") != std::string::npos);
}

TEST_CASE("a topology without this Renderer is refused") {
    RendererBench bench(1, 1, 0);
    schema::TopologyT topology;
    topology.nodes.push_back(std::make_unique<schema::NodeInfoT>());
    const std::string reason = bench.refused(bus::host_id, bus::pack(topology));
    CHECK(reason.find("node 10 is not a Renderer; there are 0 GPs and 0 frame buffers") !=
          std::string::npos);
}

TEST_CASE("a frame that cannot be sent is a fault, and the next one is drawn") {
    RendererBench bench(1, 1, 0);
    bench.take(first_gp, begin(1, {0}));
    bench.from_gp(0, programs(1, 0, {{0, {{0, 3, sheet(0, 5000)}}}}));
    bench.out.refused = Body::RegionPixels;
    CHECK_THROWS_AS(bench.work(), bus::NodeFault);
    bench.work();  // Nothing remains that could be sent again.
    CHECK(bench.frames().empty());

    bench.out.refused = Body::NONE;
    bench.take(first_gp, begin(2, {0}));
    bench.from_gp(0, programs(2, 0, {{0, {{0, 3, sheet(1, 5000)}}}}));
    bench.work();
    REQUIRE(bench.frames().size() == 1);
    CHECK(bench.frames()[0]->frame() == 2);
    CHECK(is_all(*bench.frames()[0], 0, colors[1]));
}

TEST_CASE("with two frame buffers, each gets one message with the regions of its view") {
    for (const bool has_depths : {false, true}) {
        RendererBench bench(1, 2, 1, 2);
        // Regions 0 to 2 are the left eye's, 3 to 5 the right eye's.
        bench.take(first_gp, begin(5, {1, 0, 1, 0, 1, 0}, {16, has_depths, 0, 1, 2}));
        bench.from_gp(
            0, programs(5, 0, {{2, {{0, 3, sheet(0, 5000)}}}, {4, {{1, 3, sheet(1, 4000)}}}}));
        bench.work();
        CHECK(bench.faults().empty());
        REQUIRE(bench.frames(0).size() == 1);
        REQUIRE(bench.frames(1).size() == 1);
        const schema::RegionPixels &left = *bench.frames(0)[0], &right = *bench.frames(1)[0];
        REQUIRE(left.tiles()->size() == 2);
        CHECK(left.tiles()->Get(0)->region() == 0);
        CHECK(left.tiles()->Get(1)->region() == 2);
        CHECK(is_all(left, 0, background));
        CHECK(is_all(left, 1, colors[0]));
        REQUIRE(right.tiles()->size() == 1);
        CHECK(right.tiles()->Get(0)->region() == 4);
        CHECK(is_all(right, 0, colors[1]));
        REQUIRE((right.depths() != nullptr) == has_depths);
        if (has_depths) {
            REQUIRE(left.depths()->size() == tile);
            CHECK(left.depths()->Get(0) == (1 | 5000 << 8));
            REQUIRE(right.depths()->size() == tile);
            CHECK(right.depths()->Get(0) == (2 | 4000 << 8));
        }
    }
}

TEST_CASE("a frame buffer of which a Renderer has no region gets a message, of no view none") {
    RendererBench bench(1, 2, 1, 2);
    bench.take(first_gp, begin(5, {0, 1}, {16, false, 0, 1, 2}));
    bench.from_gp(0, programs(5, 0, {}));
    bench.take(first_gp, begin(6, {1, 0}));
    bench.from_gp(0, programs(6, 0, {}));
    bench.work();
    REQUIRE(bench.frames(0).size() == 2);
    CHECK(bench.frames(0)[0]->tiles()->size() == 0);
    CHECK(bench.frames(0)[1]->frame() == 6);
    CHECK(bench.frames(0)[1]->tiles()->size() == 1);
    REQUIRE(bench.frames(1).size() == 1);
    CHECK(bench.frames(1)[0]->frame() == 5);
    CHECK(bench.frames(1)[0]->tiles()->size() == 1);
}

TEST_CASE("a frame without a frame buffer to send it to is refused") {
    RendererBench bench(1, 1, 0);
    schema::TopologyT topology;
    topology.nodes.push_back(std::make_unique<schema::NodeInfoT>());
    bench.refused(bus::host_id, bus::pack(topology));
    CHECK(bench.refused(first_gp, begin(1, {0})) == "frame 1: the topology has no frame buffer");
}
