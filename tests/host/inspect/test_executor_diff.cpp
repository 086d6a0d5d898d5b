// Two executors that part at a known instruction, pixel and bit.
#include "host/inspect/diff/executor_diff.hpp"

#include <doctest/doctest.h>

#include "isa/assemble.hpp"
#include "tests/host/inspect/wrong_executors.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
namespace inspect = host::inspect;
using Where = inspect::StateBit::Where;
using Kind = PartKind;

namespace {

using Words = std::vector<std::uint32_t>;

/// Parts of a region; the words outlive the plan.
renderer::RegionPlan plan_of(const std::vector<Words>& parts) {
    renderer::RegionPlan plan;
    for (const Words& words : parts) {
        renderer::RegionPlan::Part part;
        part.segment.words = words;
        plan.parts.push_back(part);
    }
    plan.parts.front().kind = Kind::prologue;
    plan.parts.back().kind = Kind::end_of_region;
    return plan;
}

Words assembled(const char* text) {
    return isa::assemble(text).bind({});
}

/// Clearing as a region's prologue does it.
Words cleared() {
    return assembled("SETENABS\nCONSTintoMEM m0:32 0xffffff00\nCLEARMEM m32:30\n");
}

/// Small triangles about the middle, each in front of those before it.
Words triangles(std::size_t count) {
    test::RandomPrograms random(1);
    Words words;
    for (std::size_t i = 0; i < count; ++i) {
        test::TrianglePlanes t;
        const auto at = static_cast<std::int32_t>(800 + i % 13);
        test::put_edges({at, at}, {at + 160, at}, {at, at + 160}, t);
        t.z[2] = (0x7000 - static_cast<std::int32_t>(i)) << 16;
        t.surface = static_cast<std::uint32_t>(1 + i % 200);
        append(t, words);
    }
    return words;
}

}  // namespace

TEST_CASE("executors that agree have no first difference") {
    const std::vector<Words> parts = {cleared(), triangles(100), assembled("PIXELSTOFB m64:24")};
    const renderer::RegionPlan plan = plan_of(parts);
    CHECK_FALSE(inspect::first_divergence(plan, test::reference_maker(),
                                          [] { return std::make_unique<renderer::fast::Fast>(); }));
}

TEST_CASE("one instruction that goes wrong is found, with pixel, field, bit and both values") {
    // Depths of the reference, 80 triangles on: deep in the second chunk.
    const std::vector<Words> parts = {cleared(), triangles(20), triangles(120),
                                      assembled("PIXELSTOFB m64:24")};
    const renderer::RegionPlan plan = plan_of(parts);
    const std::uint32_t surface = 1 + 80;
    const auto wrong =
        test::wrong_maker([=](isa::Instruction in, isa::Coefficients, isa::Executor& executor) {
            if (in == isa::Instruction{isa::Op::imm_into_mem, {0, surface, 8}}) {
                executor.execute({isa::Op::not_mem, {100, 0, 1}}, {});
            }
        });
    const auto found = inspect::first_divergence(plan, test::reference_maker(), wrong);
    REQUIRE(found);
    CHECK(found->address.part == 2);
    CHECK(found->address.word == 80 * 34 + isa::triangle::at_surface);
    CHECK(found->instructions == 1);
    CHECK(found->bit.where == Where::memory);
    CHECK(found->bit.bit == 100);
    CHECK(found->first == 0);
    CHECK(found->second == 0x10);
    CHECK(inspect::to_text(found->bit) == "m[96 : 112), bit 4 (m[100])");
    // The first pixel of the triangle, row by row: corner (802, 802) + (160, 0) in 1/16 pixel.
    CHECK(found->bit.y == 51);
    CHECK(found->bit.x == 51);
}

TEST_CASE("enables, carries, blocks and readouts that go wrong are differences") {
    struct Row {
        const char* program;
        isa::Op behind;
        isa::Instruction mistake;
        Where where;
    };
    using isa::Op;
    const Row rows[] = {
        {"SETENABS\nIMMintoMEM m0:8 #1\nNOP", Op::imm_into_mem, {Op::clr_enabs, {}}, Where::enable},
        {"SETENABS\nMEMpluseqMEM m0:8 m8\nIMMintoMEM m8:8 #3",
         Op::imm_into_mem,
         {Op::mem_minus_mem, {16, 8, 8}},
         Where::carry},
        {"SETENABS\nIMMintoMEM m0:8 #1\nBSWRITE m0 bs4\nBSWAIT\n",
         Op::bs_write,
         {Op::bs_write, {32, 4, 0}},
         Where::backing},
        {"SETENABS\nIMMintoMEM m0:8 #1\nPIXELSTOFB m0:8",
         Op::pixels_to_fb,
         {Op::pixels_to_fb, {40, 0, 8}},
         Where::readout},
    };
    for (const Row& row : rows) {
        CAPTURE(row.program);
        const std::vector<Words> parts = {assembled(row.program)};
        const auto found = inspect::first_divergence(
            plan_of(parts), test::reference_maker(),
            test::wrong_maker([&](isa::Instruction in, isa::Coefficients, isa::Executor& e) {
                if (in.op == row.behind) {
                    e.execute(row.mistake, {});
                }
            }));
        REQUIRE(found);
        CHECK(static_cast<int>(found->bit.where) == static_cast<int>(row.where));
        CHECK(isa::decode(parts[0][found->address.word])->op == row.behind);
        CHECK(found->first != found->second);
    }
}

TEST_CASE("an instruction in a program with jumps is found where it ran") {
    const std::vector<Words> parts = {assembled(R"(
        SETENABS
        LOOP #3
            MEMpluseqCONST m0:8 5
        ENDLOOP
        ANYENAB
        SKIPIFNONE over
        NOTMEM m8:8
        over:
        NOP
    )")};
    const auto found = inspect::first_divergence(
        plan_of(parts), test::reference_maker(),
        test::wrong_maker([](isa::Instruction in, isa::Coefficients, isa::Executor& e) {
            if (in.op == isa::Op::not_mem && e.field(0, 0, 0, 8) == 15) {
                e.execute({isa::Op::imm_into_mem, {100, 1, 8}}, {});
            }
        }));
    REQUIRE(found);
    CHECK(isa::decode(parts[0][found->address.word])->op == isa::Op::not_mem);
    CHECK(found->bit.bit == 100);
}

TEST_CASE("what goes wrong only in a run of triangles is reported with the run") {
    const std::vector<Words> parts = {cleared(), triangles(300)};
    const renderer::RegionPlan plan = plan_of(parts);
    const auto one =
        inspect::first_divergence(plan, test::reference_maker(), test::wrong_ahead_maker(1));
    REQUIRE(one);
    CHECK(one->address.word == 0);
    CHECK(one->instructions == 10);
    CHECK(one->bit.bit == 11);
    const auto five =
        inspect::first_divergence(plan, test::reference_maker(), test::wrong_ahead_maker(5));
    REQUIRE(five);
    CHECK(five->instructions == 50);
    const auto many =
        inspect::first_divergence(plan, test::reference_maker(), test::wrong_ahead_maker(200));
    REQUIRE(many);
    CHECK(many->instructions == 2000);
}
