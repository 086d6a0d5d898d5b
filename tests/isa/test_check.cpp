// Tests the rules of check() and their messages.
#include <doctest/doctest.h>

#include "isa/assemble.hpp"
#include "isa/disassemble.hpp"
#include "isa/program.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using isa::Op;

namespace {

using Words = std::vector<std::uint32_t>;

Words word(Op op, isa::Operands o) {
    return {isa::encode({op, o})};
}

/// Fails unless check() refuses `words` at `at` with a reason that contains all of `parts`.
void refused(const Words& words, std::size_t at, std::initializer_list<std::string_view> parts) {
    const isa::CheckResult result = isa::check(words);
    REQUIRE_FALSE(result.ok());
    CHECK(result.error->word == at);
    for (const std::string_view part : parts) {
        CHECK_MESSAGE(result.error->text.find(part) != std::string::npos, result.error->text,
                      " lacks ", part);
    }
}

void refused(std::string_view text, std::size_t at, std::initializer_list<std::string_view> parts) {
    refused(isa::assemble(text).words, at, parts);
}

}  // namespace

TEST_CASE("a valid program's facts are counts of its text") {
    const isa::CheckResult result =
        isa::check(isa::assemble("SETENABS\nTREEgeZERO :16 1 2 3\nMULMEM m0:8 m16\n").words);
    REQUIRE(result.ok());
    CHECK(result.facts.instructions == 3);
    CHECK(result.facts.cycles == 1 + 20 + 192);
    CHECK_FALSE(result.facts.has_flow);
    CHECK(isa::check({}).ok());
}

TEST_CASE("a word that is no instruction is refused by its value") {
    refused(Words{0x01000000, 0xff000000}, 1, {"0xff000000", "no row"});
    refused(Words{0x01000001}, 0, {"0x01000001", "must be 0"});
}

TEST_CASE("missing coefficients are refused") {
    refused(Words{isa::encode({Op::tree_ge_zero, {0, 0, 8}}), 1, 2}, 0,
            {"TREEgeZERO", "3 coefficient", "has 2 more words"});
}

TEST_CASE("operands out of range are refused, with both values") {
    refused(word(Op::clear_mem, {0, 0, 0}), 0, {"CLEARMEM", "n is 0", "1..64"});
    refused(word(Op::clear_mem, {0, 0, 65}), 0, {"n is 65", "1..64"});
    refused(word(Op::sqrt_mem, {0, 0, 33}), 0, {"n is 33", "1..32"});
    refused(word(Op::clear_mem, {200, 0, 9}), 0, {"m[a]", "200..208", "208"});
    refused(word(Op::mul_mem, {150, 0, 30}), 0, {"m[a]", "150..209"});
    refused(word(Op::mem_into_mem, {0, 207, 2}), 0, {"m[b]", "207..208"});
    refused(word(Op::bs_read, {177, 0, 0}), 0, {"m[a]", "177..208"});
    refused(word(Op::bs_read, {0, 128, 0}), 0, {"block b is 128", "127"});
    Words tree = word(Op::tree_into_mem, {0, 64, 8});
    tree.insert(tree.end(), 3, 0);
    refused(tree, 0, {"fraction b is 64", "63"});
    CHECK(isa::check(word(Op::clear_mem, {144, 0, 64})).ok());
    CHECK(isa::check(word(Op::mul_mem, {144, 176, 32})).ok());
}

TEST_CASE("jumps reach instructions of the program only") {
    refused("NOP\nCALL 5\nNOP", 1, {"CALL", "word 5", "4 words"});
    refused("CALL 3\nCONSTintoMEM m0:8 7\nRET", 0, {"word 3 is not an instruction"});
    refused("NOP\nSKIPIFNONE 0", 1, {"SKIPIFNONE", "back to word 0"});
    refused("NOP\nSKIPIFNONE 1", 1, {"SKIPIFNONE", "back to word 1"});
    refused("SKIPIFNONE end\nLOOP #2\nend: NOP\nENDLOOP", 0, {"another LOOP"});
    refused("LOOP #2\nCALL end\nend: NOP\nENDLOOP", 1, {"another LOOP"});
    refused("LOOP #2\nRET\nENDLOOP", 1, {"RET inside the LOOP of word 0"});
    CHECK(isa::check(isa::assemble("LOOP #2\nSKIPIFNONE end\nNOP\nend: ENDLOOP").words).ok());
    CHECK(isa::check(isa::assemble("NOP\nSKIPIFNONE end\nNOP\nend:").words).ok());
}

TEST_CASE("loops balance and have a limit") {
    refused("LOOP #2\nNOP", 0, {"without an ENDLOOP"});
    refused("NOP\nENDLOOP", 1, {"without a LOOP"});
    std::string nine;
    for (int i = 0; i < 9; ++i) {
        nine += "LOOP #1\n";
    }
    refused(nine, 8, {"depth 9", "limit is 8"});
}

TEST_CASE("what a transfer uses is left alone until BSWAIT") {
    refused("BSREAD m0 bs1\nMEMintoMEM m31 m64:8", 1, {"MEMintoMEM", "m[0 : 32)", "since word 0"});
    refused("BSWRITE m40 bs1\nNOTMEM m71:1\nBSWAIT", 1, {"NOTMEM", "m[40 : 72)"});
    refused("BSREAD m0 bs1\nBSWRITE m64 bs1\nBSWAIT", 1, {"block 1"});
    refused("BSREAD m0 bs1\nNOP", 0, {"block 1", "at the program's end"});
    refused("BSREAD m0 bs1\nEOR", 1, {"EOR", "block 1"});
    refused("LOOP #2\nBSREAD m0 bs1\nENDLOOP\nBSWAIT", 2, {"ENDLOOP", "insert BSWAIT"});
    CHECK(isa::check(isa::assemble("BSREAD m0 bs1\nCLEARMEM m32:64\nBSWAIT\nCLEARMEM m0:32").words)
              .ok());
}

TEST_CASE("damaged programs are refused or still valid, never a crash") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(31);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    std::size_t refusals = 0;
    for (int i = 0; i < 60; ++i) {
        const Words whole = random.program();
        for (int k = 0; k < 50; ++k) {
            Words words = whole;
            const auto size = static_cast<std::uint32_t>(words.size());
            words[random.below(size)] ^= 1U << random.below(32);
            words.resize(words.size() - random.below(3));
            const isa::CheckResult result = isa::check(words);
            refusals += result.ok() ? 0 : 1;
            if (!result.ok()) {
                CHECK(result.error->word < words.size());
            }
            CHECK_FALSE(isa::disassemble(words).empty());
        }
    }
    CHECK(refusals > 500);
}

TEST_CASE("binding fills parameters in and names what is wrong") {
    const isa::Program program = isa::assemble(
        "CONSTintoMEM m0:8 $level\nIMMintoMEM m8:8 #$count\nTREEgeZERO :16 1 $level 3");
    const Words words = program.bind({{"level", -7}, {"count", 200}});
    CHECK(isa::disassemble(words) ==
          "CONSTintoMEM m0:8  -7\nIMMintoMEM m8:8 #200\nTREEgeZERO :16  1 -7 3\n");
    CHECK_THROWS_WITH_AS(program.bind({{"level", 1}}), "parameter $count has no value",
                         isa::ParameterError);
    CHECK_THROWS_WITH_AS(program.bind({{"level", 1}, {"count", 1}, {"other", 2}}),
                         "the program has no parameter $other", isa::ParameterError);
    CHECK_THROWS_WITH_AS(program.bind({{"level", 1}, {"count", 256}}),
                         "parameter $count is 256; it must be 0..255", isa::ParameterError);
    CHECK_THROWS_AS(program.bind({{"level", std::int64_t{1} << 32}, {"count", 1}}),
                    isa::ParameterError);
}
