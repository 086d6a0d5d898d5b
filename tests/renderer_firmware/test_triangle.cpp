// Compares fused triangles with the reference, which runs them instruction by instruction.
#include "isa/sequencer.hpp"
#include "tests/isa/lockstep.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/targets.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
using isa::reference::Reference;
using isa::reference::Window;
using renderer::fast::Fast;

namespace {

/// Sets z to far, and all other bits and carries to noise, so that a wrong write shows.
std::vector<std::uint32_t> start() {
    using isa::Op;
    std::vector<std::uint32_t> words = {isa::encode({Op::set_enabs, {}})};
    for (std::uint32_t a = 0; a + 52 <= isa::memory_bits; a += 52) {
        words.insert(words.end(), {isa::encode({Op::tree_into_mem, {a, 0, 52}}), 0x01234567,
                                   0x0FEDCBA9, 0x1111111});
    }
    words.insert(words.end(), {isa::encode({Op::mem_plus_tree, {100, 3, 30}}), 0x0133557, 77, 5});
    words.insert(words.end(), {isa::encode({Op::const_into_mem, {8, 0, 24}}), 0xFFFFFFFF});
    return words;
}

/// Runs `words` on both executors and compares all pixels of the window.
void compare_runs(const std::vector<std::uint32_t>& words, Window window, Fast& fast) {
    REQUIRE(isa::check(words).ok());
    Reference reference(window);
    test::Lockstep both(reference, fast);
    isa::Controller trusted, tested;
    const isa::RunCounts expected = isa::run(words, reference, trusted);
    const isa::RunCounts found = isa::run(words, fast, tested);
    REQUIRE_NOTHROW(both.compare_all("after the triangles"));
    CHECK(found.instructions == expected.instructions);
    CHECK(found.cycles == expected.cycles);
}

}  // namespace

TEST_CASE("random triangles, run fused, leave memory, carries and enables of the reference") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(4711);
    for (std::uint64_t seed = first; seed < first + 400; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        const Window window{static_cast<int>(random.below(113)),
                            static_cast<int>(random.below(117)), 16, 12};
        std::vector<std::uint32_t> words = start();
        test::append_random_triangles(random, 1 + random.below(20), words);
        // Overlapping triangles that certainly reach the window.
        for (int i = 0; i < 12; ++i) {
            const test::Corner center{(window.x0 + 8) * 16, (window.y0 + 6) * 16};
            append(test::random_triangle(random, center, 8 << random.below(6)), words);
        }
        test::on_every_target([&](Fast& fast) { compare_runs(words, window, fast); });
    }
}

TEST_CASE("edges with any coefficients, wrapped or unbounded, agree with the reference") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(99);
    for (std::uint64_t seed = first; seed < first + 200; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        const Window window{static_cast<int>(random.below(121)),
                            static_cast<int>(random.below(125)), 8, 4};
        std::vector<std::uint32_t> words = start();
        for (int i = 0; i < 8; ++i) {
            test::TrianglePlanes t = test::random_triangle(random, {1024, 1024}, 1000);
            for (auto& edge : t.edges) {
                for (std::int32_t& k : edge) {
                    k = random.below(3) == 0 ? k : random.coefficient();
                }
            }
            append(t, words);
        }
        test::on_every_target([&](Fast& fast) { compare_runs(words, window, fast); });
    }
}

TEST_CASE("sign tests of any width, too narrow for their edge too, agree with the reference") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(500);
    for (std::uint64_t seed = first; seed < first + 200; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        const Window window{static_cast<int>(random.below(121)),
                            static_cast<int>(random.below(125)), 8, 4};
        std::vector<std::uint32_t> words = start();
        for (int i = 0; i < 8; ++i) {
            // Up to 50 pixels: Q often exceeds 16 bits, and exceeds 24 bits only with long edges.
            const auto at = [&] { return static_cast<std::int32_t>(random.below(2048)); };
            test::TrianglePlanes t =
                test::random_triangle(random, {at(), at()}, 8 << random.below(12));
            for (std::uint32_t& width : t.widths) {
                constexpr std::uint32_t widths[] = {0, 8, 15, 16, 16, 16, 24, 24, 32, 64};
                width = widths[random.below(10)];
            }
            append(t, words);
        }
        test::on_every_target([&](Fast& fast) { compare_runs(words, window, fast); });
    }
}

TEST_CASE("slivers and triangles over the whole region agree on every pixel") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(31);
    for (std::uint64_t seed = first; seed < first + 2; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        std::vector<std::uint32_t> words = start();
        const test::Corner far[3] = {{-3000, -3000}, {9000, -2000}, {-2500, 9000}};
        test::TrianglePlanes whole = test::random_triangle(random, {0, 0}, 10);
        put_edges(far[0], far[1], far[2], whole);
        append(whole, words);
        for (int i = 0; i < 6; ++i) {
            const auto at = [&] { return static_cast<std::int32_t>(random.below(2048)); };
            const test::Corner p{at(), at()}, q{at(), at()};
            test::TrianglePlanes sliver = test::random_triangle(random, {0, 0}, 10);
            put_edges(p, q, {q.x + 1 + static_cast<std::int32_t>(random.below(20)), q.y}, sliver);
            append(sliver, words);
        }
        test::on_every_target([&](Fast& fast) { compare_runs(words, {}, fast); });
    }
}

TEST_CASE("of two triangles at equal depth the first stays") {
    test::on_every_target([](Fast& fast) {
        test::RandomPrograms random(1);
        std::vector<std::uint32_t> words = start();
        test::TrianglePlanes t = test::random_triangle(random, {0, 0}, 10);
        put_edges({160, 160}, {800, 160}, {160, 800}, t);
        t.z[0] = t.z[1] = 0;
        t.surface = 1;
        append(t, words);
        t.surface = 2;
        append(t, words);
        isa::Controller controller;
        isa::run(words, fast, controller);
        CHECK(fast.field(12, 12, 0, 8) == 1);
        CHECK_FALSE(fast.any_enabled());
        t.z[2] -= 256;  // One step of the stored z.
        words.clear();
        append(t, words);
        isa::run(words, fast, controller);
        CHECK(fast.field(12, 12, 0, 8) == 2);
        CHECK(fast.enabled(12, 12));
        CHECK_FALSE(fast.enabled(60, 60));
    });
}

TEST_CASE("triangles are run fused: the executor takes them all at once") {
    test::on_every_target([](Fast& fast) {
        test::RandomPrograms random(3);
        std::vector<std::uint32_t> words;
        for (int i = 0; i < 10; ++i) {
            append(test::random_triangle(random, {900, 900}, 100), words);
        }
        const isa::Taken taken = fast.execute_ahead(words);
        CHECK(taken.words == words.size());
        CHECK(taken.instructions == 10 * isa::triangle::instruction_count);
    });
}

TEST_CASE("a fused run that ends before an odd triangle leaves what its instructions leave") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(1300);
    for (std::uint64_t seed = first; seed < first + 60; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        const Window window{56, 58, 8, 8};
        // From no triangle to a few more than three of the largest batch.
        const std::size_t before = random.below(52);
        std::vector<std::uint32_t> words;
        for (std::size_t i = 0; i < before + 4; ++i) {
            test::TrianglePlanes t = test::random_triangle(random, {960, 992}, 100);
            // Each one precedes the others, so that the last one leaves enables.
            t.z[0] = t.z[1] = 0;
            t.z[2] = (1000 - static_cast<std::int32_t>(i)) << 12;
            t.widths[0] = i == before ? 40 : 0;  // Not a width of the shape.
            append(t, words);
        }
        const std::size_t fused = before * isa::triangle::word_count;
        test::on_every_target([&](Fast& fast) {
            Reference reference(window);
            test::Lockstep both(reference, fast);
            isa::Controller trusted, tested;
            isa::run(start(), reference, trusted);
            isa::run(start(), fast, tested);
            const isa::RunCounts expected =
                isa::run(std::span(words).first(fused), reference, trusted);
            if (before > 0) {
                const isa::Taken taken = fast.execute_ahead(words);
                REQUIRE(taken.words == fused);
                CHECK(taken.instructions == expected.instructions);
                CHECK(taken.cycles == expected.cycles);
            }
            REQUIRE_NOTHROW(both.compare_all("before the odd triangle"));
        });
    }
}
