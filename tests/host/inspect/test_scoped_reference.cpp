// The quick reference against the plain one, and its boxes against every pixel.
#include <doctest/doctest.h>

#include "host/base/error.hpp"
#include "host/inspect/replay/scoped_reference.hpp"
#include "isa/sequencer.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
using host::inspect::ScopedReference;
using isa::reference::Reference;
using isa::reference::Window;

namespace {

/// Far z, and rubbish elsewhere.
std::vector<std::uint32_t> start() {
    using isa::Op;
    return {isa::encode({Op::set_enabs, {}}),
            isa::encode({Op::tree_into_mem, {40, 0, 52}}),
            0x01234567,
            0x0FEDCBA9,
            0x1111111,
            isa::encode({Op::mem_plus_tree, {100, 3, 30}}),
            0x0133557,
            77,
            5,
            isa::encode({Op::const_into_mem, {8, 0, 24}}),
            0xFFFFFFFF};
}

void run(const std::vector<std::uint32_t>& words, isa::Executor& executor, isa::RunCounts& counts) {
    isa::Controller controller;
    const isa::RunCounts more = isa::run(words, executor, controller);
    counts.instructions += more.instructions;
    counts.cycles += more.cycles;
}

/// The first pixel whose memory, enable or carry differs, as a text.
std::string difference(const isa::Executor& p, const isa::Executor& q) {
    for (int y = 0; y < region_px; ++y) {
        for (int x = 0; x < region_px; ++x) {
            bool same = p.enabled(x, y) == q.enabled(x, y) && p.carry(x, y) == q.carry(x, y);
            for (std::uint32_t a = 0; a < isa::memory_bits; a += 52) {
                same = same && p.field(x, y, a, 52) == q.field(x, y, a, 52);
            }
            if (!same) {
                return "(" + std::to_string(x) + ", " + std::to_string(y) + ")";
            }
        }
    }
    return "";
}

}  // namespace

TEST_CASE("triangles in their boxes leave what they leave on all pixels") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(2024);
    for (std::uint64_t seed = first; seed < first + 6; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        ScopedReference scoped;
        Reference plain;
        isa::RunCounts in_boxes, on_all;
        std::vector<std::uint32_t> words = start();
        for (int round = 0; round < 3; ++round) {
            test::append_random_triangles(random, 7, words);
            append(test::random_triangle(random, {1024, 1024}, 300), words);
            test::TrianglePlanes wrapped = test::random_triangle(random, {1024, 1024}, 3000);
            wrapped.widths[random.below(3)] = 16;  // Too few bits in some places.
            append(wrapped, words);
            if (round == 1) {  // What follows triangles sees their enables.
                words.push_back(isa::encode({isa::Op::imm_into_mem, {150, 0x5A, 8}}));
                words.push_back(isa::encode({isa::Op::inv_enabs, {}}));
                words.push_back(isa::encode({isa::Op::imm_into_mem, {160, 0xA5, 8}}));
            }
            run(words, scoped, in_boxes);
            run(words, plain, on_all);
            REQUIRE(difference(scoped, plain) == "");
            words.clear();
        }
        CHECK(in_boxes.instructions == on_all.instructions);
        CHECK(in_boxes.cycles == on_all.cycles);
    }
}

TEST_CASE("triangles of one step after another are those of one run") {
    test::RandomPrograms random(test::seed_or<std::uint64_t>(5));
    std::vector<std::uint32_t> words = start();
    test::append_random_triangles(random, 6, words);
    ScopedReference stepped, whole;
    isa::Controller controller;
    isa::Sequencer steps(words, stepped, controller);
    while (!steps.done()) {
        steps.step();
    }
    isa::RunCounts counts;
    run(words, whole, counts);
    CHECK(difference(stepped, whole) == "");
    CHECK(steps.counts().cycles == counts.cycles);
}

TEST_CASE("the reference executor ends a region that needs too much work, and names both values") {
    const isa::Instruction add{isa::Op::mem_plus_const, {0, 0, 32}};
    const std::int32_t one = 1;
    const std::uint64_t work =
        std::uint64_t{isa::info(add.op).cycles(add.operands)} * region_pixels;
    ScopedReference executor(3 * work);
    for (int n = 0; n < 3; ++n) {
        CHECK_NOTHROW(executor.execute(add, {&one, 1}));
    }
    const ScopedReference::State done = executor.save();
    for (int n = 0; n < 2; ++n) {
        CHECK_THROWS_WITH_AS(
            executor.execute(add, {&one, 1}),
            ("the reference executor has needed " + std::to_string(4 * work) +
             " cycles of pixels for a region; the limit is " + std::to_string(3 * work) +
             ". The recorded programs may be crafted. To execute them nevertheless, choose "
             "--executor fast")
                .c_str(),
            host::RequestError);
        executor.restore(done);
    }
    // A triangle needs work for the pixels of its box.
    test::RandomPrograms random(7);
    std::vector<std::uint32_t> triangles;
    test::append_random_triangles(random, 50, triangles);
    ScopedReference enough(50 * work), small(work);
    CHECK(enough.execute_ahead(triangles).words == triangles.size());
    CHECK_THROWS_AS(small.execute_ahead(triangles), host::RequestError);
}

TEST_CASE("the box of a triangle holds the pixels that pass its sign tests, and is no larger") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(77);
    int empty = 0, filled = 0;
    for (std::uint64_t seed = first; seed < first + 60; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        std::vector<std::uint32_t> words;
        test::append_random_triangles(random, 1, words);
        const Window box = host::inspect::triangle_box(words.data());
        int x0 = 128, y0 = 128, x1 = -1, y1 = -1;
        for (int y = 0; y < 128; ++y) {
            for (int x = 0; x < 128; ++x) {
                bool inside = true;
                for (const std::size_t at : isa::triangle::at_edge) {
                    const auto k = [&](std::size_t i) {
                        return std::int64_t{static_cast<std::int32_t>(words[at + i])};
                    };
                    inside = inside && k(1) * x + k(2) * y + k(3) >= 0;
                }
                if (inside) {
                    x0 = std::min(x0, x), x1 = std::max(x1, x);
                    y0 = std::min(y0, y), y1 = std::max(y1, y);
                }
            }
        }
        if (x1 < 0) {
            CHECK(box.width == 0);
            ++empty;
        } else {
            CHECK(box.x0 == x0);
            CHECK(box.y0 == y0);
            CHECK(box.width == x1 - x0 + 1);
            CHECK(box.height == y1 - y0 + 1);
            ++filled;
        }
    }
    CHECK(empty > 5);
    CHECK(filled > 20);
}

TEST_CASE("an edge that leaves its bits bounds nothing: its sign test wraps") {
    std::vector<std::uint32_t> words;
    test::TrianglePlanes planes;
    for (auto& edge : planes.edges) {
        edge[2] = -40'000;  // Of which bit 15 is 0, though Q is negative.
    }
    planes.widths[0] = planes.widths[1] = planes.widths[2] = 16;
    planes.edges[0][0] = 1000;
    append(planes, words);
    const Window box = host::inspect::triangle_box(words.data());
    CHECK(box.width == 128);
    CHECK(box.height == 128);
}
