// Tests the controller: calls, loops, skips, signals and limits.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <string>

#include "isa/assemble.hpp"
#include "isa/reference/reference.hpp"
#include "isa/sequencer.hpp"

using namespace pxpl5;

namespace {

constexpr isa::reference::Window one_pixel{.x0 = 0, .y0 = 0, .width = 1, .height = 1};

struct Machine {
    isa::reference::Reference pixel{one_pixel};
    isa::Controller controller;
    std::vector<std::uint32_t> signals;

    Machine() {
        controller.on_signal = [this](std::uint32_t n) { signals.push_back(n); };
    }
    isa::RunCounts run(std::string_view text) {
        const std::vector<std::uint32_t> words = isa::assemble(text).words;
        const isa::CheckResult result = isa::check(words);
        REQUIRE_MESSAGE(result.ok(), result.error->text);
        return isa::run(words, pixel, controller);
    }
    std::uint64_t byte() const { return pixel.field(0, 0, 0, 8); }
};

}  // namespace

TEST_CASE("loops run as often as they say, nested and not at all") {
    Machine m;
    const isa::RunCounts counts = m.run(
        "SETENABS\nLOOP #3\nLOOP #5\nMEMpluseqCONST m0:8 1\nENDLOOP\nMEMpluseqCONST m0:8 "
        "20\nENDLOOP\n"
        "LOOP #0\nLOOP #2\nMEMpluseqCONST m0:8 100\nENDLOOP\nENDLOOP");
    CHECK(m.byte() == 75);
    CHECK(counts.instructions == 1 + 1 + 3 * (1 + 5 * 2 + 1 + 1) + 1);
    CHECK(counts.cycles == 1 + 4 + 3 * (4 + 5 * (16 + 4) + 16 + 4) + 4);
}

TEST_CASE("calls return behind themselves and EOR ends the stream") {
    Machine m;
    m.run("SETENABS\nCALL add\nCALL add\nEOR\nadd: MEMpluseqCONST m0:8 7\nRET");
    CHECK(m.byte() == 14);
}

TEST_CASE("SKIPIFNONE follows the flag of the last ANYENAB, also of an earlier stream") {
    Machine m;
    m.run("SETENABS\nANYENAB\nCLRENABS\nSKIPIFNONE end\nSIGNAL #1\nend: ANYENAB");
    m.run("SETENABS\nSKIPIFNONE end\nSIGNAL #2\nend: SIGNAL #3");
    CHECK(m.signals == std::vector<std::uint32_t>{1, 3});
}

TEST_CASE("a run that would never end stops at the limit and says so") {
    Machine m;
    m.controller.step_limit = 1000;
    CHECK_THROWS_WITH_AS(m.run("LOOP #255\nLOOP #255\nNOP\nENDLOOP\nENDLOOP"),
                         "word 2: the run executed 1001 instructions; the limit is 1000",
                         isa::RunError);
}

TEST_CASE("the usual limit ends loops and calls that repeat too much") {
    Machine m;
    REQUIRE(isa::max_repeated_instructions == 4'194'304);
    std::string loops, ends;
    for (std::size_t depth = 0; depth < isa::max_loop_depth; ++depth) {
        loops += "LOOP #255\n";
        ends += "ENDLOOP\n";
    }
    CHECK_THROWS_WITH_AS(m.run(loops + "NOP\n" + ends),
                         "word 9: the run executed 4194322 instructions; the limit is 4194321",
                         isa::RunError);
    // Seven levels of 16 calls each are 16^7 rounds of the last routine.
    std::string calls;
    for (int level = 0; level < 7; ++level) {
        calls += fmt::format("level{}:\n", level);
        for (int i = 0; i < 16; ++i) {
            calls += fmt::format("CALL level{}\n", level + 1);
        }
        calls += level == 0 ? "EOR\n" : "RET\n";
    }
    CHECK_THROWS_WITH_AS(m.run(calls + "level7: NOP\nRET\n"), doctest::Contains("; the limit is "),
                         isa::RunError);
}

TEST_CASE("the usual limit ends no program that executes each word once") {
    Machine m;
    const std::size_t count = isa::max_repeated_instructions + 1000;
    const std::vector<std::uint32_t> words(count, isa::assemble("NOP").words.at(0));
    REQUIRE(isa::check(words).ok());
    CHECK(isa::run(words, m.pixel, m.controller).instructions == count);
}

TEST_CASE("calls and loops that go too deep end the run") {
    Machine m;
    CHECK_THROWS_WITH_AS(m.run("again: NOP\nCALL again"), "word 1: CALL at depth 9; the limit is 8",
                         isa::RunError);
    CHECK_THROWS_WITH_AS(m.run("NOP\nRET"), "word 1: RET without a CALL", isa::RunError);
    CHECK_THROWS_WITH_AS(
        m.run(
            "LOOP #1\nLOOP #1\nLOOP #1\nLOOP #1\nCALL "
            "sub\nENDLOOP\nENDLOOP\nENDLOOP\nENDLOOP\nEOR\n"
            "sub: LOOP #1\nLOOP #1\nLOOP #1\nLOOP #1\nLOOP #1\nENDLOOP\nENDLOOP\nENDLOOP\nENDLOOP\n"
            "ENDLOOP\nRET"),
        "word 15: LOOP at depth 9, calls included; the limit is 8", isa::RunError);
}

namespace {

/// Runs the first two instructions as one step.
class Ahead final : public isa::Executor {
  public:
    std::size_t executed = 0, ahead = 0;
    void execute(isa::Instruction, isa::Coefficients) override { ++executed; }
    isa::Taken execute_ahead(std::span<const std::uint32_t> words) override {
        ++ahead;
        return ahead == 1 ? isa::Taken{words.size() - 1, 2, 30} : isa::Taken{};
    }
    bool any_enabled() const override { return true; }
    std::uint64_t field(int, int, std::uint32_t, std::uint32_t) const override { return 0; }
    bool enabled(int, int) const override { return false; }
    bool carry(int, int) const override { return false; }
    std::uint32_t backing_block(int, int, std::uint32_t) const override { return 0; }
};

}  // namespace

TEST_CASE("an executor may run ahead, and its instructions and cycles count") {
    Ahead executor;
    isa::Controller controller;
    const std::vector<std::uint32_t> words =
        isa::assemble("SETENABS\nTREEgeZERO :8 1 2 3\nCLRENABS").words;
    const isa::RunCounts counts = isa::run(words, executor, controller);
    CHECK(executor.ahead == 2);
    CHECK(executor.executed == 1);
    CHECK(counts.instructions == 3);
    CHECK(counts.cycles == 31);
}
