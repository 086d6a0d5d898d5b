// Programs reduced to what shows a mistake, and written as files that can be read again.
#include "host/inspect/diff/shrink.hpp"

#include <doctest/doctest.h>

#include "host/base/error.hpp"
#include "isa/assemble.hpp"
#include "isa/conformance/conformance_run.hpp"
#include "isa/disassemble.hpp"
#include "isa/sequencer.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"
#include "tests/host/inspect/wrong_executors.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
namespace inspect = host::inspect;
using isa::Op;

namespace {

using Words = std::vector<std::uint32_t>;

Words assembled(const char* text) {
    return isa::assemble(text).bind({});
}

std::vector<Op> ops_of(const Words& words) {
    std::vector<Op> ops;
    for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
        ops.push_back(isa::decode(words[at])->op);
    }
    return ops;
}

/// An adder that loses the carry out of 24 bits.
inspect::NamedExecutor without_carry_24() {
    return {"wrong",
            test::wrong_maker([](isa::Instruction in, isa::Coefficients, isa::Executor& executor) {
                if (in.op == Op::mem_plus_mem && in.operands.n == 24) {
                    executor.execute({Op::imm_into_mem, {207, 0, 1}}, {});
                    executor.execute({Op::mem_plus_mem, {207, 207, 1}}, {});
                }
            })};
}

const inspect::NamedExecutor reference = inspect::named(inspect::ExecutorKind::reference);

}  // namespace

TEST_CASE("a lost carry in a long random program is reduced to a handful of instructions") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(900);
    for (std::uint64_t seed = first; seed < first + 4; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        Words words;
        for (const Words& more :
             {random.program({.instructions = 300, .flow = false}),
              assembled("BSWAIT\nSETENABS\nCONSTintoMEM m0:24 0x800001\nCONSTintoMEM m40:24 "
                        "0x800000\nMEMpluseqMEM m0:24 m40"),
              Words{isa::encode({Op::clear_mem, {96, 0, 8}})}}) {
            words.insert(words.end(), more.begin(), more.end());
        }
        REQUIRE(isa::check(words).ok());
        const inspect::Shrunk shrunk =
            inspect::shrink(words, inspect::differ_at({64, 64}, reference, without_carry_24()));
        CAPTURE(isa::disassemble(shrunk.words));
        CHECK(isa::check(shrunk.words).ok());
        CHECK(shrunk.instructions <= 4);
        CHECK(shrunk.instructions_before > 300);
        const std::vector<Op> ops = ops_of(shrunk.words);
        CHECK(std::ranges::count(ops, Op::mem_plus_mem) >= 1);
        const auto plan = inspect::plan_of_program(shrunk.words);
        CHECK(inspect::first_divergence(plan, reference.make, without_carry_24().make));
    }
}

TEST_CASE("triangles that go wrong only as one keep their shape, with simple numbers") {
    test::RandomPrograms random(test::seed_or<std::uint64_t>(8));
    Words words = assembled("SETENABS\nCONSTintoMEM m0:32 0xffffff00\n");
    test::append_random_triangles(random, 50, words);
    test::TrianglePlanes front = test::random_triangle(random, {1000, 1000}, 400);
    front.z[0] = front.z[1] = 0;
    front.z[2] = 1 << 20;  // In front of all others.
    append(front, words);
    const inspect::NamedExecutor wrong{"wrong", test::wrong_ahead_maker(1)};
    const auto plan = inspect::plan_of_program(words);
    const auto found = inspect::first_divergence(plan, reference.make, wrong.make);
    REQUIRE(found);
    const inspect::RegionPixel pixel{found->bit.x, found->bit.y};
    const inspect::Shrunk shrunk = inspect::shrink(inspect::whole_program(plan, &*found),
                                                   inspect::differ_at(pixel, reference, wrong));
    CAPTURE(isa::disassemble(shrunk.words));
    // z must have been more than the triangle's somewhere before it: one enable, one constant.
    CHECK(shrunk.instructions <= 12);
    const std::span<const std::uint32_t> triangle =
        std::span(shrunk.words).last(isa::triangle::word_count);
    REQUIRE(isa::triangle::matches(triangle.data()));
    CHECK(triangle[isa::triangle::at_z_test + 3] == 0);  // And the store's, which is the same.
    CHECK(triangle[isa::triangle::at_normal[2] + 1] == 0);
    CHECK(inspect::differ_at(pixel, reference, wrong)(shrunk.words));
}

TEST_CASE("a value of a pixel is reduced to the instructions that made it") {
    const Words words = assembled(R"(
        SETENABS
        IMMintoMEM m0:8 #77
        CONSTintoMEM m100:16 4242
        TREEintoMEM m40:16 >>0  3 5 7
        MEMpluseqCONST m40:16 1
        NOTMEM m120:8
    )");
    const inspect::Shrunk shrunk =
        inspect::shrink(words, inspect::holds_at({10, 20}, {40, 16, 138}, reference));
    // 3 * 10 + 5 * 20 + 7 + 1 = 138.
    CHECK(ops_of(shrunk.words) ==
          std::vector{Op::set_enabs, Op::tree_into_mem, Op::mem_plus_const});
    isa::reference::Reference again;
    isa::Controller controller;
    isa::run(shrunk.words, again, controller);
    CHECK(again.field(10, 20, 40, 16) == 138);
}

TEST_CASE("jumps follow their targets, and loops stay whole") {
    const Words words = assembled(R"(
        NOP
        SETENABS
        IMMintoMEM m90:8 #1
        ANYENAB
        SKIPIFNONE over
        IMMintoMEM m91:8 #1
        LOOP #3
            NOP
            MEMpluseqCONST m0:8 5
        ENDLOOP
        over:
        NOP
        NOTMEM m120:8
    )");
    const inspect::Shrunk shrunk =
        inspect::shrink(words, inspect::holds_at({0, 0}, {0, 8, 15}, reference));
    CHECK(isa::check(shrunk.words).ok());
    CAPTURE(isa::disassemble(shrunk.words));
    CHECK(shrunk.instructions <= 4);
}

TEST_CASE("a jump goes to its target, wherever that has moved") {
    const Words words = assembled(R"(
        NOP
        SETENABS
        ANYENAB
        SKIPIFNONE over
        IMMintoMEM m90:8 #1
        CLEARMEM m90:8
        over:
        NOTMEM m120:8
        NOP
    )");
    const auto skips_to_not = [](std::span<const std::uint32_t> program) {
        for (std::size_t at = 0; at < program.size(); at += isa::instruction_words(program[at])) {
            if (isa::decode(program[at])->op == Op::skip_if_none &&
                program[at + 1] < program.size()) {
                return isa::decode(program[program[at + 1]])->op == Op::not_mem;
            }
        }
        return false;
    };
    const inspect::Shrunk shrunk = inspect::shrink(words, skips_to_not);
    CHECK(ops_of(shrunk.words) == std::vector{Op::skip_if_none, Op::not_mem});
}

TEST_CASE("what a program does not show cannot be shrunk") {
    const Words words = assembled("SETENABS\nIMMintoMEM m0:8 #1");
    CHECK_THROWS_AS(inspect::shrink(words, inspect::holds_at({0, 0}, {0, 8, 2}, reference)),
                    host::RequestError);
}

TEST_CASE("the programs of a region as one leave what they leave one by one") {
    const test::TracedSphere traced({128, 128}, 2, 1);
    const inspect::RecordedFrame frame = traced.run().frame(0);
    const inspect::RecordedRegion& region = frame.regions.at(0);
    const Words words = inspect::whole_program(region.plan);
    REQUIRE(isa::check(words).ok());
    renderer::fast::Fast by_parts, as_one;
    const auto pixels = inspect::run_region(region.plan, by_parts).pixels;
    CHECK(inspect::run_region(inspect::plan_of_program(words), as_one).pixels == pixels);
}

TEST_CASE("what is written can be read again and says the same") {
    const Words words = assembled("SETENABS\nTREEintoMEM m40:16 >>0  3 -5 7\nSKIPIFNONE 8\nNOP\n");
    REQUIRE(isa::check(words).ok());
    const inspect::Shrunk shrunk{words, 4, 9, 1};
    const inspect::ShrunkStory story{"reference and fast differ", "run/x, frame 3", {5, 6}};
    CHECK(isa::assemble(inspect::as_assembly(shrunk, story)).bind({}) == words);
    const isa::ConformanceCase read =
        isa::parse_conformance(inspect::as_conformance(shrunk, story));
    CHECK(read.title == story.title);
    isa::reference::Reference executor;
    CHECK(isa::first_difference(read, executor) == "");
    test::WrongExecutor wrong([](isa::Instruction in, isa::Coefficients, isa::Executor& e) {
        if (in.op == Op::tree_into_mem) {
            e.execute({Op::not_mem, {47, 0, 1}}, {});
        }
    });
    CHECK(isa::first_difference(read, wrong) != "");
    const std::string doctest = inspect::as_doctest(shrunk, story);
    CHECK(doctest.find("TEST_CASE(\"reference and fast differ\")") != std::string::npos);
    CHECK(doctest.find("TREEintoMEM m40:16 >>0  3 -5 7") != std::string::npos);
}
