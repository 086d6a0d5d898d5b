// Tests one region: the order of segments, and the effect of an invalid segment.
#include "isa/assemble.hpp"
#include "isa/reference/reference.hpp"
#include "renderer_firmware/igc/region.hpp"
#include "tests/renderer_firmware/targets.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
using renderer::Segment;

namespace {

using WordList = std::vector<std::uint32_t>;

/// A triangle over the whole region at one depth, with surface field `number`.
WordList sheet(std::uint32_t number, std::uint32_t depth) {
    test::TrianglePlanes t;
    put_edges({-3000, -3000}, {9000, -3000}, {-3000, 9000}, t);
    t.z[2] = static_cast<std::int32_t>(depth << 8);
    t.surface = number;
    WordList words;
    append(t, words);
    return words;
}

/// Clears to far and background, and reads out the surface field.
const WordList prologue = {isa::encode({isa::Op::set_enabs, {}}),
                           isa::encode({isa::Op::const_into_mem, {0, 0, 32}}), 0xFFFFFF00};
const WordList end_of_region = {isa::encode({isa::Op::pixels_to_fb, {0, 0, 8}})};

struct Drawn {
    renderer::RegionResult result;
    WordList pixels;
};

Drawn draw(isa::Executor& executor, std::vector<Segment> segments) {
    Drawn drawn;
    executor.set_readout(
        [&](renderer::Words words) { drawn.pixels.assign(words.begin(), words.end()); });
    drawn.result = draw_region(executor, {prologue, end_of_region}, std::move(segments));
    executor.set_readout({});
    return drawn;
}

}  // namespace

TEST_CASE("ties of depth go to the lower surface, then the lower slab, in any order of arrival") {
    const WordList first = sheet(1, 5000), second = sheet(2, 5000), third = sheet(3, 5000);
    std::vector<Segment> segments = {{0, 7, 3, first}, {0, 9, 0, second}, {1, 2, 1, third}};
    isa::reference::Reference reference({60, 60, 4, 4});
    CHECK(draw(reference, segments).pixels.at(61 * 128 + 62) == 1);
    test::on_every_target([&](renderer::fast::Fast& fast) {
        for (int i = 0; i < 6; ++i) {
            const Drawn drawn = draw(fast, segments);
            CHECK(drawn.pixels == WordList(128 * 128, 1));
            CHECK(drawn.result.faults.empty());
            CHECK(drawn.result.counts.instructions == 2 + 30 + 1);
            std::next_permutation(segments.begin(), segments.end(),
                                  [](const Segment& p, const Segment& q) { return p.gp < q.gp; });
        }
        // A nearer triangle hides an earlier one.
        const WordList near = sheet(9, 4999);
        std::vector<Segment> more = segments;
        more.push_back({5, 0, 0, near});
        CHECK(draw(fast, more).pixels == WordList(128 * 128, 9));
    });
}

TEST_CASE("a region without segments is what its own programs make it") {
    test::on_every_target(
        [](renderer::fast::Fast& fast) { CHECK(draw(fast, {}).pixels == WordList(128 * 128, 0)); });
}

TEST_CASE("a bad segment is left out and named, and the others are drawn") {
    test::on_every_target([](renderer::fast::Fast& fast) {
        const WordList good = sheet(4, 6000);
        WordList bad = sheet(5, 100);
        bad.push_back(0xFF000000);
        const Drawn drawn = draw(fast, {{0, 1, 0, bad}, {0, 2, 1, good}});
        CHECK(drawn.pixels == WordList(128 * 128, 4));
        REQUIRE(drawn.result.faults.size() == 1);
        CHECK(drawn.result.faults[0].slab == 1);
        CHECK(drawn.result.faults[0].gp == 0);
        CHECK(drawn.result.faults[0].reason.find("word 34") != std::string::npos);
    });
}

TEST_CASE("of the Renderer's own programs the one that is none is named, with its word") {
    const WordList wrong = {isa::encode({isa::Op::set_enabs, {}}), 0xFF000000};
    const auto refused = [](const renderer::RegionFrame& frame) -> std::string {
        try {
            check_own(frame);
        } catch (const std::logic_error& error) {
            return error.what();
        }
        return "accepted";
    };
    const auto begins = [](const std::string& text, const std::string& start) {
        CHECK_MESSAGE(text.starts_with(start), text);
    };
    CHECK(refused({prologue, end_of_region, {{0, prologue, end_of_region}}, end_of_region}) ==
          "accepted");
    begins(refused({wrong, end_of_region}), "prologue, word 1: ");
    begins(refused({prologue, wrong}), "end-of-region program, word 1: ");
    begins(refused({prologue, end_of_region, {{0, wrong, prologue}}}),
           "program that shuts a door, word 1: ");
    begins(refused({prologue, end_of_region, {{0, prologue, wrong}}}),
           "program that opens a door, word 1: ");
    begins(refused({prologue, end_of_region, {}, wrong}), "program of depths, word 1: ");
}

TEST_CASE("a surface and slab that comes twice is drawn once and named") {
    test::on_every_target([](renderer::fast::Fast& fast) {
        const WordList first = sheet(1, 6000), again = sheet(2, 10);
        const Drawn drawn = draw(fast, {{0, 4, 8, again}, {0, 4, 2, first}});
        CHECK(drawn.pixels == WordList(128 * 128, 1));
        REQUIRE(drawn.result.faults.size() == 1);
        CHECK(drawn.result.faults[0].gp == 8);
    });
}

TEST_CASE("a reset executor remembers nothing of the region before") {
    test::on_every_target([](renderer::fast::Fast& fast) {
        const WordList rubbish = {isa::encode({isa::Op::set_enabs, {}}),
                                  isa::encode({isa::Op::const_into_mem, {150, 0, 58}}),
                                  0xFFFFFFFF,
                                  isa::encode({isa::Op::mem_plus_const, {150, 0, 30}}),
                                  0x3FFFFFFF,
                                  isa::encode({isa::Op::bs_write, {150, 77, 0}}),
                                  isa::encode({isa::Op::bs_wait, {}})};
        draw(fast, {{0, 0, 0, rubbish}});
        CHECK(fast.backing_block(5, 5, 77) != 0);
        CHECK(fast.carry(5, 5));
        fast.reset();
        for (int i = 0; i < 128; ++i) {
            CHECK(fast.field(i, 127 - i, 144, 64) == 0);
            CHECK_FALSE(fast.carry(i, i));
            CHECK_FALSE(fast.enabled(i, i));
            CHECK(fast.backing_block(i, i, 77) == 0);
        }
        CHECK_FALSE(fast.any_enabled());
    });
}
