// Compares the counts of each part of a region with counts on paper.
#include <algorithm>

#include "isa/assemble.hpp"
#include "isa/reference/reference.hpp"
#include "tests/renderer_firmware/node_bench.hpp"
#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using isa::ClassCounts;
using isa::InstructionClass;
using renderer::Counting;
using renderer::PartCounts;
using test::WordList;
using Kind = PartKind;
namespace schema = bus::schema;

namespace {

WordList assembled(std::string_view text) {
    return isa::assemble(text).bind({});
}

ClassCounts of(const PartCounts& part, InstructionClass which) {
    return part.executed.classes[static_cast<std::size_t>(which)];
}

WordList triangles(std::size_t count) {
    WordList words;
    for (std::size_t i = 0; i < count; ++i) {
        const WordList one = test::sheet(0, 5000);
        words.insert(words.end(), one.begin(), one.end());
    }
    return words;
}

isa::RunCounts sum_of(const std::vector<PartCounts>& parts) {
    isa::RunCounts sum;
    for (const PartCounts& part : parts) {
        sum.instructions += part.executed.total().instructions;
        sum.cycles += part.executed.total().cycles;
    }
    return sum;
}

/// Returns the only FrameCounts of a node, and its receiver.
schema::FrameCountsT counts_of(const test::RendererBench& bench) {
    schema::FrameCountsT found;
    int count = 0;
    bool pixels_before = false;
    for (const test::RendererOutbox::Sent& s : bench.out.sent) {
        pixels_before = pixels_before || s.payload.kind() == schema::Body::RegionPixels;
        if (s.payload.kind() == schema::Body::FrameCounts) {
            ++count;
            CHECK(s.to == bus::host_id);
            CHECK_FALSE(pixels_before);
            schema::GetMessage(s.payload.bytes().data())->body_as_FrameCounts()->UnPackTo(&found);
        }
    }
    CHECK(count == 1);
    return found;
}

}  // namespace

TEST_CASE("a region of k triangles: prologue, k times one triangle, end of region") {
    const WordList prologue = assembled("SETENABS\nCONSTintoMEM m0:32 0xFFFFFF00");
    const WordList end = assembled("PIXELSTOFB m64:24");
    // Edges have 24 bits, depths 24 bits and 8 fraction bits, normals 10 and 16.
    constexpr std::uint64_t tree_cycles = 3 * (24 + 4) + 2 * (8 + 24 + 4) + 3 * (16 + 10 + 4);
    test::on_every_target([&](renderer::fast::Fast& fast) {
        for (const std::size_t k : {0U, 1U, 2U, 5U, 100U}) {
            CAPTURE(k);
            const WordList words = triangles(k);
            std::vector<renderer::Segment> segments;
            if (k > 0) {
                segments.push_back({2, 7, 1, words});
            }
            const auto result =
                draw_region(fast, {prologue, end}, segments, {}, Counting::each_part);
            REQUIRE(result.parts.size() == (k > 0 ? 3 : 2));
            CHECK(result.parts.front().kind == Kind::prologue);
            CHECK(of(result.parts.front(), InstructionClass::enable) == ClassCounts{1, 1});
            CHECK(of(result.parts.front(), InstructionClass::memory) == ClassCounts{1, 33});
            const PartCounts& last = result.parts.back();
            CHECK(last.kind == Kind::end_of_region);
            CHECK(of(last, InstructionClass::control) == ClassCounts{1, 16408});
            CHECK(last.executed.port_cycles == 16408);
            CHECK(last.executed.backing_cycles == 0);
            CHECK(result.counts.instructions == 3 + 10 * k);
            CHECK(result.counts.cycles == 34 + 16408 + k * (1 + tree_cycles + 9));
            if (k > 0) {
                const PartCounts& segment = result.parts[1];
                CHECK(segment.kind == Kind::segment);
                CHECK(segment.surface == 2);
                CHECK(segment.slab == 7);
                CHECK(segment.primitives == k);
                CHECK(segment.words == 34 * k);
                CHECK(of(segment, InstructionClass::enable) == ClassCounts{k, k});
                CHECK(of(segment, InstructionClass::tree) == ClassCounts{8 * k, k * tree_cycles});
                CHECK(of(segment, InstructionClass::memory) == ClassCounts{k, 9 * k});
                CHECK(segment.executed.port_cycles == 0);
            }
        }
    });
}

TEST_CASE("what loops or is skipped counts as often as it was executed") {
    const WordList loops = assembled("SETENABS\nLOOP #5\nCLEARMEM m64:8\nENDLOOP");
    const WordList skips =
        assembled("CLRENABS\nANYENAB\nSKIPIFNONE out\nCLEARMEM m64:24\nout: PIXELSTOFB m64:24");
    test::on_every_target([&](renderer::fast::Fast& fast) {
        const auto result = draw_region(fast, {loops, skips}, {}, {}, Counting::each_part);
        REQUIRE(result.parts.size() == 2);
        CHECK(of(result.parts[0], InstructionClass::memory) == ClassCounts{5, 45});
        CHECK(of(result.parts[0], InstructionClass::control) == ClassCounts{6, 24});
        CHECK(of(result.parts[1], InstructionClass::memory) == ClassCounts{});
        CHECK(of(result.parts[1], InstructionClass::enable) == ClassCounts{2, 5});
        CHECK(of(result.parts[1], InstructionClass::control) == ClassCounts{2, 16412});
        CHECK(sum_of(result.parts).instructions == result.counts.instructions);
        CHECK(sum_of(result.parts).cycles == result.counts.cycles);
    });
}

TEST_CASE("parts are counted only on request, and the region stays the same") {
    const WordList prologue = assembled("SETENABS\nCONSTintoMEM m0:32 0xFFFFFF00");
    const WordList end = assembled("ANYENAB\nSKIPIFNONE out\nout: PIXELSTOFB m0:8");
    const WordList words = triangles(3);
    test::on_every_target([&](renderer::fast::Fast& fast) {
        const auto draw = [&](Counting counting) {
            fast.reset();
            WordList pixels;
            fast.set_readout(
                [&](renderer::Words read) { pixels.assign(read.begin(), read.end()); });
            const auto result =
                draw_region(fast, {prologue, end}, {{0, 0, 0, words}}, {}, counting);
            fast.set_readout({});
            CHECK(result.parts.size() == (counting == Counting::each_part ? 3 : 0));
            return std::pair(pixels, std::pair(result.counts.instructions, result.counts.cycles));
        };
        CHECK(draw(Counting::each_part) == draw(Counting::whole_region));
    });
}

TEST_CASE("a Renderer tells the host each part of its regions, and their sums are its tiles'") {
    const auto draw = [](bool counts) {
        auto bench = std::make_unique<test::RendererBench>(2, 2, 1);
        schema::BeginFrameT begin;
        const bus::Payload packed = test::begin(3, {0, 1, 1}, {8, true});
        schema::GetMessage(packed.bytes().data())->body_as_BeginFrame()->UnPackTo(&begin);
        begin.draw->counts = counts;
        bench->take(test::first_gp, bus::pack(begin));
        bench->from_gp(0,
                       test::programs(3, 0, {{1, {{0, 4, triangles(2)}, {1, 2, triangles(1)}}}}));
        bench->from_gp(1, test::programs(3, 1, {{1, {{1, 3, triangles(5)}}}}));
        bench->work();
        CHECK(bench->faults().empty());
        REQUIRE(bench->frames().size() == 1);
        return bench;
    };
    const auto counted = draw(true), plain = draw(false);
    CHECK(std::ranges::none_of(plain->out.sent, [](const test::RendererOutbox::Sent& s) {
        return s.payload.kind() == schema::Body::FrameCounts;
    }));
    CHECK(std::ranges::equal(*counted->frames()[0]->pixels(), *plain->frames()[0]->pixels()));

    const schema::FrameCountsT told = counts_of(*counted);
    CHECK(told.frame == 3);
    CHECK(told.drawn.empty());
    using enum PartKind;
    struct Expected {
        int region;
        PartKind kind;
        std::uint32_t surface, slab, primitives;
    };
    const std::vector<Expected> expected = {
        {1, prologue, 0, 0, 0},     {1, segment, 0, 4, 2},       {1, shut_door, 1, 0, 0},
        {1, segment, 1, 2, 1},      {1, segment, 1, 3, 5},       {1, open_door, 1, 0, 0},
        {1, depths, 0, 0, 0},       {1, end_of_region, 0, 0, 0}, {2, prologue, 0, 0, 0},
        {2, end_of_region, 0, 0, 0}};  // Nothing is drawn in region 2: it has no depths.
    REQUIRE(told.parts.size() == expected.size());
    std::map<int, ClassCounts> sums;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const schema::PartCounts& part = told.parts[i];
        CAPTURE(i);
        CHECK(part.region() == expected[i].region);
        CHECK(part.kind() == expected[i].kind);
        CHECK(part.surface() == expected[i].surface);
        CHECK(part.slab() == expected[i].slab);
        CHECK(part.primitives() == expected[i].primitives);
        CHECK(part.words() == 34 * expected[i].primitives);
        CHECK((part.port_cycles() > 0) == (part.kind() == depths || part.kind() == end_of_region));
        for (std::uint16_t c = 0; c < isa::class_count; ++c) {
            sums[part.region()] +=
                {part.classes()->Get(c)->instructions(), part.classes()->Get(c)->cycles()};
        }
    }
    for (const schema::RegionTile* tile : *counted->frames()[0]->tiles()) {
        CHECK(sums.at(tile->region()) == ClassCounts{tile->instructions(), tile->cycles()});
        CHECK(tile->has_depths() == (tile->region() == 1));
    }
    CHECK(std::ranges::equal(*counted->frames()[0]->tiles(), *plain->frames()[0]->tiles(),
                             [](const auto* p, const auto* q) {
                                 return p->cycles() == q->cycles() &&
                                        p->instructions() == q->instructions();
                             }));
}

TEST_CASE("a pass tells what it waits for the backing store") {
    test::RendererBench bench(1, 1, 0);
    for (std::uint8_t sample = 0; sample < 2; ++sample) {
        bench.out.sent.clear();
        schema::BeginFrameT begin;
        const bus::Payload packed = test::begin(1U + sample, {0}, {full_opacity, false, sample, 4});
        schema::GetMessage(packed.bytes().data())->body_as_BeginFrame()->UnPackTo(&begin);
        begin.draw->counts = true;
        bench.take(test::first_gp, bus::pack(begin));
        bench.from_gp(0, test::programs(1U + sample, 0, {}));
        bench.work();
        const schema::FrameCountsT told = counts_of(bench);
        REQUIRE(told.parts.size() == 2);
        // The first pass writes its sums. The second pass loads them first. Both wait.
        CHECK(told.parts[1].backing_cycles() == (sample == 0 ? 16000 : 32000));
        CHECK(told.parts[1].port_cycles() == 0);
    }
}
