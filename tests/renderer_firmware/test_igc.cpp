#include <doctest/doctest.h>

#include "isa/assemble.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "isa/reference/reference.hpp"
#include "renderer_firmware/igc/igc.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/targets.hpp"
#include "tests/renderer_firmware/triangles.hpp"

using namespace pxpl5;
using isa::reference::Reference;

TEST_CASE("the controller counts what the sequencer counts on the reference") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(77);
    for (std::uint64_t seed = first; seed < first + 50; ++seed) {
        CAPTURE(seed);
        test::RandomPrograms random(seed);
        std::vector<std::uint32_t> words = random.program({.instructions = 60, .flow = false});
        test::append_random_triangles(random, 5, words);
        Reference reference({0, 0, 4, 4});
        isa::Controller controller;
        const isa::RunCounts expected = isa::run(words, reference, controller);
        test::on_every_target([&](renderer::fast::Fast& fast) {
            const renderer::Outcome found = renderer::Igc(fast).run(words);
            REQUIRE_FALSE(found.error);
            CHECK(found.counts.instructions == expected.instructions);
            CHECK(found.counts.cycles == expected.cycles);
        });
    }
}

TEST_CASE("a stream of nothing but triangles is known as such, and passes the check") {
    test::RandomPrograms random(5);
    std::vector<std::uint32_t> words;
    test::append_random_triangles(random, 7, words);
    CHECK(renderer::only_triangles(words));
    CHECK(isa::check(words).ok());
    CHECK(renderer::only_triangles({}));
    for (std::size_t at = 0; at < words.size(); ++at) {
        std::vector<std::uint32_t> broken = words;
        broken[at] ^= 0x80000001U;
        // A changed coefficient gives another triangle, except in one copy of the z plane.
        if (!isa::check(broken).ok()) {
            CHECK_FALSE(renderer::only_triangles(broken));
        }
    }
    words.pop_back();
    CHECK_FALSE(renderer::only_triangles(words));
}

TEST_CASE("a bad stream runs nothing and names its word") {
    test::on_every_target([](renderer::fast::Fast& fast) {
        std::vector<std::uint32_t> words;
        test::RandomPrograms random(6);
        test::append_random_triangles(random, 2, words);
        const std::size_t at = words.size();
        words.push_back(0xEE000000);
        const renderer::Outcome outcome = renderer::Igc(fast).run(words);
        REQUIRE(outcome.error);
        CHECK(outcome.error->word == at);
        CHECK(outcome.counts.instructions == 0);
        CHECK_FALSE(fast.any_enabled());
    });
}
