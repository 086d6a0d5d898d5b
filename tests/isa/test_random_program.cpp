#include <doctest/doctest.h>
#include <fmt/format.h>

#include <set>

#include "isa/sequencer.hpp"
#include "tests/isa/lockstep.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;

TEST_CASE("random programs are valid and reach every row") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(1);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms programs(seed);
    std::set<std::string_view> seen;
    for (int i = 0; i < 100; ++i) {
        const std::vector<std::uint32_t> words = programs.program();
        const isa::CheckResult result = isa::check(words);
        REQUIRE_MESSAGE(result.ok(), "program ", i, ", word ", result.error->word, ": ",
                        result.error->text);
        CHECK(result.facts.instructions >= 200);
        for (std::size_t at = 0; at < words.size(); at += isa::instruction_words(words[at])) {
            seen.insert(isa::info(isa::decode(words[at])->op).name);
        }
    }
    for (const isa::OpInfo& row : isa::op_table) {
        CHECK_MESSAGE(seen.contains(row.name), row.name, " never came");
    }
}

TEST_CASE("a window of the reference computes what the whole region computes there") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(2);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms programs(seed);
    const std::vector<std::uint32_t> words = programs.program({.instructions = 120});
    isa::reference::Reference window({.x0 = 120, .y0 = 37, .width = 8, .height = 5}), whole;
    test::Lockstep both(window, whole);
    isa::Controller controller;
    CHECK_NOTHROW(CHECK(isa::run(words, both, controller).instructions >= 120));
    CHECK_NOTHROW(both.compare_all("at the end"));
}

TEST_CASE("random programs keep a good part of the pixels enabled") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(3);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms programs(seed);
    std::size_t enabled = 0, mixed = 0, steps = 0;
    for (int i = 0; i < 10; ++i) {
        const std::vector<std::uint32_t> words = programs.program();
        isa::reference::Reference pixels({.x0 = 40, .y0 = 60, .width = 8, .height = 8});
        isa::Controller controller;
        for (isa::Sequencer s(words, pixels, controller); !s.done(); s.step(), ++steps) {
            std::size_t count = 0;
            for (int k = 0; k < 64; ++k) {
                count += pixels.enabled(40 + k % 8, 60 + k / 8) ? 1 : 0;
            }
            enabled += count;
            mixed += count != 0 && count != 64 ? 1 : 0;
        }
    }
    MESSAGE(fmt::format("{:.0f} % of pixels enabled, {:.0f} % of steps with some",
                        100.0 * static_cast<double>(enabled) / static_cast<double>(64 * steps),
                        100.0 * static_cast<double>(mixed) / static_cast<double>(steps)));
    CHECK(enabled > 64 * steps / 4);
    CHECK(mixed > steps / 4);
}
