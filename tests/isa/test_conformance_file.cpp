// Tests the text form of conformance cases and its error messages.
#include <doctest/doctest.h>

#include "isa/conformance/conformance_run.hpp"
#include "isa/reference/reference.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using isa::parse_conformance;
using Kind = isa::StateColumn::Kind;

namespace {

void refused(const std::string& text, std::size_t line, std::size_t column,
             const std::string& what) {
    INFO(text);
    try {
        parse_conformance(text);
        FAIL_CHECK("accepted");
    } catch (const isa::ConformanceError& error) {
        INFO(error.what());
        CHECK(error.line == line);
        CHECK(error.column == column);
        CHECK(std::string(error.what()).find(what) != std::string::npos);
        CHECK(std::string(error.what())
                  .starts_with("line " + std::to_string(line) + ", column " +
                               std::to_string(column) + ": "));
    }
}

std::string difference(const std::string& text) {
    isa::reference::Reference pixels({.x0 = 0, .y0 = 0, .width = 4, .height = 2});
    return first_difference(parse_conformance(text), pixels, {0, 0, 3, 1});
}

}  // namespace

TEST_CASE("a case is read as it stands") {
    const isa::ConformanceCase test = parse_conformance(
        "; words\n"
        "title  What it shows ; not this\r\n"
        "watch 0..3,5 *,127\n"
        "given m8:24 enable bs127\n"
        "  all x*x-3*y+0x10 1 -\n"
        "  7,0..9 -1 - 12\n"
        "  2*x-y-5>=0 2*x*y - -\n"
        "run\n"
        "  .def z 8\n"
        "  again: CLEARMEM m[z]:24\n"
        "expect carry readout\n"
        "signals 3 255\nflag 0\ninstructions 4\ncycles 99\nstops at  depth 9\n");
    CHECK(test.title == "What it shows");
    REQUIRE(test.watch.size() == 2);
    CHECK(test.watch[0] == isa::PixelRectangle{0, 5, 3, 5});
    CHECK(test.watch[1] == isa::PixelRectangle{0, 127, 127, 127});
    REQUIRE(test.given.size() == 1);
    const isa::StateTable& given = test.given[0];
    CHECK(given.columns[0] == isa::StateColumn{Kind::field, 8, 24});
    CHECK(given.columns[1] == isa::StateColumn{Kind::enable, 0, 1});
    CHECK(given.columns[2] == isa::StateColumn{Kind::block, 127, 32});
    REQUIRE(given.rows.size() == 3);
    CHECK(given.rows[0].values[0]->at(10, 4) == 100 - 12 + 16);
    CHECK_FALSE(given.rows[0].values[2]);
    CHECK(given.rows[1].values[0]->at(1, 2) == ~std::uint64_t{0});
    CHECK(given.rows[1].where.selects(7, 9));
    CHECK_FALSE(given.rows[1].where.selects(7, 10));
    CHECK(given.rows[2].where.selects(3, 1));
    CHECK_FALSE(given.rows[2].where.selects(3, 2));
    CHECK(given.rows[2].values[0]->at(5, 7) == 70);
    CHECK(test.program.words == std::vector<std::uint32_t>{0x23080018});
    CHECK(test.expect[0].columns[1] == isa::StateColumn{Kind::readout, 0, 32});
    CHECK(test.signals == std::vector<std::uint32_t>{3, 255});
    CHECK_FALSE(test.flag);
    CHECK(test.instructions == 4);
    CHECK(test.cycles == 99);
    CHECK(test.stops == "at depth 9");
}

TEST_CASE("what is no case is refused with line, column, found and expected") {
    refused("title none", 1, 1, "no section 'run'");
    refused("run\nrum", 2, 1, "found 'rum', expected title, watch");
    refused("  NOP\nrun", 1, 3, "expected a section's name");
    refused("given m0:8 m1\nrun", 1, 14, "'m1' ends, expected ':'");
    refused("given m200:9\nrun", 1, 7, "must have 1..64 bits within the 208 bits of a pixel");
    refused("given m0:0\nrun", 1, 7, "must have 1..64 bits");
    refused("given m0:65\nrun", 1, 10, "above 64");
    refused("given bs128\nrun", 1, 9, "above 127");
    refused("given readout\nrun", 1, 7, "a column of 'expect', not of 'given'");
    refused("given color\nrun", 1, 7, "found 'color', expected m0:8");
    refused("given m0:8\n  all\nrun", 2, 6, "the line ends, expected a value");
    refused("given m0:8\n  all 1 2\nrun", 2, 9, "found '2', expected the end of the line");
    refused("given m0:8\n  128,0 1\nrun", 2, 3, "above 127");
    refused("given m0:8\n  4..3,0 1\nrun", 2, 3, "'4..3,0' contains no pixel");
    refused("given m0:8\n  3 1\nrun", 2, 4, "expected ','");
    refused("given m0:8\n  x>=1 1\nrun", 2, 4, "expected '>=0'");
    refused("given m0:8\n  all 1+\nrun", 2, 9, "expected a number");
    refused("given m0:8\n  all z\nrun", 2, 7, "found 'z', expected a number");
    refused("given m0:8\n  all x*y*x\nrun", 2, 11,
            "the degree of the product in x and y is above 2");
    refused("given m0:8\n  all 0x80000000*x\nrun", 2, 7, "does not fit a signed 32-bit number");
    refused("given m0:8\n  all 0x10000000000000000\nrun", 2, 7, "above 18446744073709551615");
    refused("run\n NOP\nrun", 3, 1, "the case already has 'run' in line 1");
    refused("signals 256\nrun", 1, 9, "above 255");
    refused("flag\nrun", 1, 5, "the line ends, expected a value");
    refused("title t\nrun\n  NOP\n  CLEARMEM m200:9", 4, 3, "field m[a] is bits 200..208");
    refused("run\n  SIGNAL #$n", 1, 1, "parameter $n has no value");
    refused("run\n  LOOP #1", 1, 1, "word 0 of the program: LOOP without an ENDLOOP");
}

TEST_CASE("damaged text is refused with its place or read, never a crash") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(43);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    const std::string text =
        "title t\nwatch 0..3,5 *,127\ngiven m8:24 enable bs127\n  all x*x-3*y+0x10 1 -\n"
        "  2*x-y>=0 2*x*y - 7\nrun\n  CLEARMEM m8:24\nexpect m8:24 carry\n  3,5 0 1\nflag 0\n";
    constexpr std::string_view bits = "mbsxy:,.*->=+0 9a;\n\t\x80";
    std::size_t refusals = 0;
    for (int i = 0; i < 3000; ++i) {
        std::string damaged = text;
        damaged[random.below(static_cast<std::uint32_t>(text.size()))] =
            bits[random.below(static_cast<std::uint32_t>(bits.size()))];
        try {
            parse_conformance(damaged);
        } catch (const isa::ConformanceError& error) {
            ++refusals;
            CHECK(error.line >= 1);
            CHECK(error.column >= 1);
        }
    }
    CHECK(refusals > 1000);
    CHECK(refusals < 3000);
}

TEST_CASE("the first difference names pixel, field and both values") {
    const std::string sum =
        "given m3:8 enable\n all 200 1\n 2,1 7 1\nrun\n MEMpluseqCONST m3:8 100\n";
    CHECK(difference(sum + "expect m3:8 carry\n all 44 1\n 2,1 107 0").empty());
    CHECK(difference(sum + "expect m3:8 carry\n all 44 1") ==
          "pixel (2, 1): m3:8 is 0x6b, expected 0x2c");
    CHECK(difference(sum + "expect m3:8 carry\n all 44 1\n 2,1 107 -") ==
          "pixel (2, 1): carry is 0, expected 1");
    CHECK(difference("run\n SETENABS\n") == "pixel (0, 0): enable is 1, expected 0");
    CHECK(difference("run\n SETENABS\n NOTMEM m99:2\nexpect enable\n all 1") ==
          "pixel (0, 0): m99:1 is 0x1, expected 0x0");
    CHECK(difference("given bs7 enable\n all 5 1\nrun\n BSWRITE m0 bs7\n BSWAIT\n") ==
          "pixel (0, 0): bs7 is 0x0, expected 0x5");
    CHECK(difference("run\n PIXELSTOFB m0:8\nexpect readout\n 3,1 9") ==
          "pixel (3, 1): readout is 0x0, expected 0x9");
}

TEST_CASE("what the controller tells is compared") {
    CHECK(difference("run\n SIGNAL #3\n") == "signals are [3], expected []");
    CHECK(difference("run\n ANYENAB\n") == "flag is 0, expected 1");
    CHECK(difference("run\n PIXELSTOFB m0:8\n") == "pixels were read out, expected none");
    CHECK(difference("run\nexpect readout\n all 0") == "nothing was read out, expected a readout");
    CHECK(difference("run\n NOP\ninstructions 2") == "the run took 1 instructions, expected 2");
    CHECK(difference("run\n BSWAIT\ncycles 1") == "the run took 16000 cycles, expected 1");
    CHECK(difference("run\n RET\n") ==
          "the run stopped with 'word 0: RET without a CALL', expected ''");
    CHECK(difference("run\n RET\nstops RET without").empty());
    CHECK(difference("run\nstops RET") == "the run stopped with '', expected 'RET'");
}

TEST_CASE("enables that differ need a free bit of memory to be set up") {
    const std::string full = "given m0:64 m64:64 m128:64 m192:16 enable\n all 1 2 3 4 0\n";
    CHECK_THROWS_WITH_AS(difference(full + " 1,1 1 2 3 4 1\nrun\n"),
                         doctest::Contains("the given fields use all 208 bits of memory"),
                         std::invalid_argument);
    const std::string almost = "given m0:64 m64:64 m128:64 m193:15 enable\n all -1 -1 -1 -1 0\n";
    CHECK(difference(full + "run\n").empty());
    CHECK(difference(almost + " 1,1 - - - - 1\nrun\n").empty());
}
