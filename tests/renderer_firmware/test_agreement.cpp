// Compares the fast executor with the reference after each instruction of random programs.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include "isa/sequencer.hpp"
#include "tests/isa/lockstep.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"
#include "tests/renderer_firmware/targets.hpp"

using namespace pxpl5;
using isa::reference::Reference;
using isa::reference::Window;
using renderer::fast::Fast;
using renderer::fast::Target;

namespace {

constexpr std::uint64_t first_seed = 20240501;
constexpr std::uint64_t step_limit = 20'000;

/// Runs the program of `seed` in lock step. Throws test::Divergence that names the seed.
void run_in_lockstep(std::uint64_t seed, Window window, Fast& fast) {
    const std::vector<std::uint32_t> words = test::RandomPrograms(seed).program();
    Reference reference(window);
    test::Lockstep both(reference, fast);
    isa::Controller controller;
    controller.step_limit = step_limit;
    try {
        isa::run(words, both, controller);
    } catch (const isa::RunError&) {
        // Random loops may take too long; the executed part was compared.
    } catch (const test::Divergence& found) {
        throw test::Divergence(fmt::format("seed {}: {}", seed, found.what()));
    }
    both.compare_all(fmt::format("end of seed {}", seed));
}

/// Returns a window of 6 x 4 pixels whose position depends on the seed.
Window small_window(std::uint64_t seed) {
    return {static_cast<int>(seed * 37 % 123), static_cast<int>(seed * 53 % 125), 6, 4};
}

void check_programs(std::uint64_t begin, std::uint64_t end) {
    const std::uint64_t first = test::seed_or<std::uint64_t>(first_seed);
    for (std::uint64_t i = begin; i < end; ++i) {
        test::on_every_target([&](Fast& fast) {
            REQUIRE_NOTHROW(run_in_lockstep(first + i, small_window(i), fast));
        });
    }
}

int pixels_that_differ(const Fast& p, const Fast& q) {
    int count = 0;
    for (int y = 0; y < region_px; ++y) {
        for (int x = 0; x < region_px; ++x) {
            bool same = p.enabled(x, y) == q.enabled(x, y) && p.carry(x, y) == q.carry(x, y);
            for (std::uint32_t a = 0; a < isa::memory_bits; a += 52) {
                same = same && p.field(x, y, a, 52) == q.field(x, y, a, 52);
            }
            count += same ? 0 : 1;
        }
    }
    return count;
}

std::string first_divergence(const renderer::fast::Backend& code, std::uint64_t programs) {
    for (std::uint64_t i = 0; i < programs; ++i) {
        Fast fast(code);
        try {
            run_in_lockstep(first_seed + i, small_window(i), fast);
        } catch (const test::Divergence& found) {
            return found.what();
        }
    }
    return {};
}

}  // namespace

// 1,000 programs of at least 200 instructions, in quarters of one or two seconds.
TEST_CASE("random programs agree with the reference on every target: first quarter") {
    check_programs(0, 250);
}
TEST_CASE("random programs agree with the reference on every target: second quarter") {
    check_programs(250, 500);
}
TEST_CASE("random programs agree with the reference on every target: third quarter") {
    check_programs(500, 750);
}
TEST_CASE("random programs agree with the reference on every target: last quarter") {
    check_programs(750, 1000);
}

TEST_CASE("random programs agree with the reference on the whole region") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(first_seed + 100'000);
    std::uint64_t seed = first;
    test::on_every_target(
        [&](Fast& fast) { REQUIRE_NOTHROW(run_in_lockstep(seed++, Window{}, fast)); });
}

TEST_CASE("running ahead leaves what instruction by instruction leaves") {
    const std::uint64_t first = test::seed_or<std::uint64_t>(first_seed + 200'000);
    for (std::uint64_t i = 0; i < 60; ++i) {
        CAPTURE(first + i);
        const std::vector<std::uint32_t> words = test::RandomPrograms(first + i).program();
        test::on_every_target([&](Fast& ahead) {
            Fast stepped;
            isa::Controller stepping, running;
            stepping.step_limit = running.step_limit = step_limit;
            isa::Sequencer steps(words, stepped, stepping);
            try {
                while (!steps.done()) {
                    steps.step();
                }
            } catch (const isa::RunError&) {
                CHECK_THROWS_AS(isa::run(words, ahead, running), isa::RunError);
                return;  // The two executors stop at different instructions.
            }
            const isa::RunCounts found = isa::run(words, ahead, running);
            CHECK(found.instructions == steps.counts().instructions);
            CHECK(found.cycles == steps.counts().cycles);
            CHECK(pixels_that_differ(stepped, ahead) == 0);
        });
    }
}

TEST_CASE("a wrong handler is caught, and the text names its instruction and the seed") {
    const renderer::fast::Backend& right = renderer::fast::backend(Target::best);
    REQUIRE(first_divergence(right, 5).empty());

    struct Planted {
        isa::Op victim, instead;
    };
    // The rows of each pair differ only in signedness, carry, rounding or comparison.
    const Planted bugs[] = {
        {isa::Op::mem_lt_const_s, isa::Op::mem_lt_const},
        {isa::Op::mem_satplus_mem, isa::Op::mem_plus_mem},
        {isa::Op::mul_mem_s, isa::Op::mul_mem},
        {isa::Op::tree_ge_mem, isa::Op::tree_lt_mem},
        {isa::Op::enab_and_mem, isa::Op::mem_into_enab},
    };
    for (const Planted bug : bugs) {
        renderer::fast::Backend wrong = right;
        wrong.handlers[static_cast<std::size_t>(bug.victim)] =
            right.handlers[static_cast<std::size_t>(bug.instead)];
        const std::string found = first_divergence(wrong, 200);
        INFO(found);
        CHECK(found.find(isa::info(bug.victim).name) != std::string::npos);
        CHECK(found.find("seed") != std::string::npos);
    }
}

TEST_CASE("a target that this machine lacks is refused by name") {
    const std::vector<Target> targets = isa::available_targets();
    for (const Target target : {Target::sse4, Target::avx2, Target::avx512}) {
        if (std::find(targets.begin(), targets.end(), target) == targets.end()) {
            CHECK_THROWS_WITH_AS(renderer::fast::backend(target),
                                 doctest::Contains(std::string(enum_name(target)).c_str()),
                                 std::invalid_argument);
        } else {
            CHECK_NOTHROW(renderer::fast::backend(target));
        }
    }
    // Targets share no code.
    if (targets.size() >= 2) {
        const bool shared = renderer::fast::backend(targets[0]).handlers[0] ==
                            renderer::fast::backend(targets[1]).handlers[0];
        CHECK_FALSE(shared);
    }
}
