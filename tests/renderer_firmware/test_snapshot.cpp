// Tests saved and restored states: a run that was disturbed and restored equals an undisturbed run.
#include <doctest/doctest.h>

#include <cstring>
#include <set>

#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"
#include "renderer_firmware/fast/fast.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using isa::reference::Reference;
using isa::reference::Window;
using renderer::fast::Fast;

namespace {

constexpr Window window{.x0 = 93, .y0 = 70, .width = 6, .height = 4};
constexpr std::uint64_t most_instructions = 1000;  ///< Limit per program: its loops may be long.
using Words = std::vector<std::uint32_t>;

/// Instructions that change every pixel: noise in memory, enables, carries and blocks.
void disturb(isa::Executor& executor, test::RandomPrograms& random) {
    executor.execute({isa::Op::inv_enabs, {}}, {});
    executor.execute({isa::Op::not_mem, {0, 0, 64}}, {});
    executor.execute({isa::Op::set_enabs, {}}, {});
    for (std::uint32_t a : {0U, 64U, 128U}) {
        executor.execute({isa::Op::not_mem, {a, 0, 64}}, {});
    }
    executor.execute({isa::Op::not_mem, {192, 0, 16}}, {});
    executor.execute({isa::Op::mem_plus_mem, {random.below(100), 100, 64}}, {});
    for (int i = 0; i < 3; ++i) {
        executor.execute({isa::Op::bs_write, {random.below(176), random.below(128), 0}}, {});
    }
    executor.execute({isa::Op::mem_into_enab, {random.below(isa::memory_bits), 0, 0}}, {});
}

bool same_pixel(const isa::Executor& p, const isa::Executor& q, int x, int y, bool blocks) {
    bool same = p.enabled(x, y) == q.enabled(x, y) && p.carry(x, y) == q.carry(x, y);
    for (std::uint32_t a = 0; a < isa::memory_bits; a += 52) {
        same = same && p.field(x, y, a, 52) == q.field(x, y, a, 52);
    }
    for (std::uint32_t block = 0; blocks && block < isa::backing_blocks; ++block) {
        same = same && p.backing_block(x, y, block) == q.backing_block(x, y, block);
    }
    return same;
}

bool same_window(const isa::Executor& p, const isa::Executor& q, bool blocks) {
    bool same = p.any_enabled() == q.any_enabled();
    for (int i = 0; i < window.width * window.height; ++i) {
        same = same &&
               same_pixel(p, q, window.x0 + i % window.width, window.y0 + i / window.width, blocks);
    }
    return same;
}

bool same_everywhere(const Reference&, const Reference&) {
    return true;  // The window is all there is to compare.
}
bool same_everywhere(const Fast& p, const Fast& q) {
    return std::memcmp(&p.pixels(), &q.pixels(), sizeof p.pixels()) == 0;
}

/// Runs `words` twice in step: on `plain`, and on `tried` with a disturbance after each
/// instruction, after which a new sequencer and a new controller continue. Adds to `seen` the rows
/// before each disturbance.
template <isa::Restorable Executor>
void run_disturbed(const Words& words, Executor& plain, Executor& tried,
                   test::RandomPrograms& random, std::set<isa::Op>& seen) {
    isa::Controller controller, old_controller;
    isa::Sequencer sequencer(words, plain, controller);
    isa::Sequencer::State at;
    bool flag = controller.flag;
    while (!sequencer.done() && sequencer.counts().instructions < most_instructions) {
        const isa::Op op = isa::decode(words[sequencer.at()])->op;
        isa::Controller other;
        other.flag = flag;
        isa::Sequencer again(words, tried, other);
        again.restore(at);
        sequencer.step();
        again.step();
        const typename Executor::State pixels = tried.save();
        at = again.state();
        flag = other.flag;
        disturb(tried, random);
        REQUIRE_FALSE(same_window(plain, tried, false));
        tried.restore(pixels);
        REQUIRE(at.at == sequencer.at());
        REQUIRE(at.counts.cycles == sequencer.counts().cycles);
        REQUIRE(flag == controller.flag);
        const bool blocks = isa::info(op).b_role == isa::Role::block;
        REQUIRE_MESSAGE(same_window(plain, tried, blocks), "after ", isa::info(op).name);
        REQUIRE_MESSAGE(same_everywhere(plain, tried), "after ", isa::info(op).name);
        seen.insert(op);
    }
    CHECK(same_window(plain, tried, true));
}

}  // namespace

TEST_CASE("a restored fast executor goes on as if nothing had happened, after every row") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(11);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms programs(seed), noise(seed + 1);
    std::set<isa::Op> seen;
    for (int i = 0; i < 12; ++i) {
        Fast plain, tried;
        run_disturbed(programs.program(), plain, tried, noise, seen);
    }
    CHECK(seen.size() > isa::op_count * 9 / 10);
}

TEST_CASE("a restored reference goes on as if nothing had happened, after every row") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(12);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms programs(seed), noise(seed + 1);
    std::set<isa::Op> seen;
    for (int i = 0; i < 60; ++i) {
        Reference plain(window), tried(window);
        run_disturbed(programs.program(), plain, tried, noise, seen);
    }
    for (const isa::OpInfo& row : isa::op_table) {
        const auto op = static_cast<isa::Op>(&row - isa::op_table.data());
        CHECK_MESSAGE(seen.contains(op), row.name, " never came");
    }
}

TEST_CASE("a state of one fast executor can be restored into another") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(13);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms programs(seed);
    Fast one, other;
    isa::Controller controller;
    isa::run(programs.program({.flow = false}), one, controller);
    disturb(other, programs);
    other.restore(one.save());
    CHECK(same_everywhere(one, other));
    CHECK(same_window(one, other, true));
}
