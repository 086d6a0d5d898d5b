// Tests the assembler and its error messages.
#include <doctest/doctest.h>

#include "isa/assemble.hpp"
#include "isa/disassemble.hpp"
#include "isa/nearest.hpp"
#include "tests/isa/random_program.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;

namespace {

std::string round_trip(std::string_view text) {
    return isa::disassemble(isa::assemble(text).words);
}

void refused(std::string_view text, std::size_t line, std::size_t column, std::string_view what) {
    try {
        isa::assemble(text);
        FAIL("accepted: ", text);
    } catch (const isa::AssemblyError& error) {
        CHECK(std::string(error.what()).find(what) != std::string::npos);
        INFO(error.what());
        CHECK(error.line == line);
        CHECK(error.column == column);
    }
}

}  // namespace

TEST_CASE("names, expressions, comments and blanks are as ASSEMBLER.md says") {
    CHECK(round_trip(".def z 8 ; depth\n.def step 2*z+1\n\n"
                     "  TREEltMEM m[z]:24   >>8  3 -5 0x10 ; test\r\n"
                     "IMMintoMEM m[z+2*8]:step-9 #step\n"
                     "MEMintoMEM m0 m32:8\n"
                     "CONSTintoMEM m8:32 -2147483648\nCONSTintoMEM m8:32 4294967295") ==
          "TREEltMEM m8:24 >>8  3 -5 16\nIMMintoMEM m24:8 #17\nMEMintoMEM m0 m32:8\n"
          "CONSTintoMEM m8:32  -2147483648\nCONSTintoMEM m8:32  -1\n");
}

TEST_CASE("labels are word offsets, ahead or behind") {
    const isa::Program program = isa::assemble("SKIPIFNONE end\nsub: NOP\nCALL sub\nend:");
    CHECK(program.words[1] == 5);
    CHECK(program.words[4] == 2);
    CHECK(program.labels.at("end") == 5);
}

TEST_CASE("errors name line, column, what was found and what was expected") {
    refused("NOP\n  FROB m8", 2, 3, "found 'FROB', expected an instruction");
    refused("TREEgeZERO 16 1 2 3", 1, 12, "found '16', expected ':'");
    refused("TREEgeZERO :16 1 2", 1, 19, "found the end of the line, expected coefficient 3 of 3");
    refused("TREEgeZERO :16 1 2 3 4", 1, 22, "found '4', expected the end of the line");
    refused("TREEgeZERO :65 1 2 3", 1, 1, "n is 65; it must be 1..64");
    refused("CLEARMEM m[z]:8", 1, 12, "found 'z', expected a number or a name of .def");
    refused("CLEARMEM m300:8", 1, 11, "operand a is 300, expected 0..255");
    refused("CLEARMEM m[8:8", 1, 13, "found ':8', expected ']'");
    refused("CLEARMEM m8:", 1, 13, "found the end of the line, expected a number");
    refused("CLEARMEM m8x:8", 1, 11, "found '8x:8', expected a number");
    refused(".def z 1\n.def z 2", 2, 6, "'z' is already defined as 1");
    refused("a: NOP\na: NOP", 2, 1, "label 'a' is already defined at word 0");
    refused("NOP\nCALL nowhere", 2, 6, "found 'nowhere', expected a label");
    refused("CONSTintoMEM m0:8 99999999999", 1, 19, "above 4294967295");
    refused("CONSTintoMEM m0:8 4294967295+1", 1, 19, "outside");
    refused("CONSTintoMEM m0:8 4294967295*4294967295", 1, 19, "outside");
    refused("CONSTintoMEM m0:8 $", 1, 20, "expected a parameter's name");
    refused("NOP NOP", 1, 5, "expected the end of the line");
    refused("]", 1, 1, "found ']', expected an instruction, a label or .def");
}

TEST_CASE("an unknown name is answered with the nearest known name") {
    refused("QUADGEZERO :9 1 2 3 4 5 6", 1, 1,
            "found 'QUADGEZERO', expected an instruction. Did you mean 'QUADgeZERO'?");
    refused("quadltzero :9 1 2 3 4 5 6", 1, 1, "Did you mean 'QUADltZERO'?");
    refused("SETENABLES", 1, 1, "Did you mean 'SETENABS'?");
    refused(".def depth 8\nCLEARMEM m[dept]:8", 2, 12, "Did you mean 'depth'?");
    refused("CALL agian\nEOR\nagain: RET", 1, 6, "Did you mean 'again'?");
    try {
        isa::assemble("XYZZYXYZZY m8");
        FAIL("accepted");
    } catch (const isa::AssemblyError& error) {
        CHECK(std::string(error.what()) ==
              "line 1, column 1: found 'XYZZYXYZZY', expected an instruction");
    }
}

TEST_CASE("an operand that is missing or wrong is answered with the instruction's syntax") {
    refused("TREEgeZERO 16 1 2 3", 1, 12, "Syntax: TREEgeZERO :n A B C");
    refused("QUADltMEM m0:8 >>2 1 2 3", 1, 25, "Syntax: QUADltMEM ma:n >>b A B C D E F");
    refused("MEMintoMEM m0:8 m8", 1, 14, "Syntax: MEMintoMEM mb ma:n");
    refused("CONSTintoMEM m0:8", 1, 18, "Syntax: CONSTintoMEM ma:n K");
    refused("NOP 1", 1, 5, "Syntax: NOP");
}

TEST_CASE("binary words are refused with the tool that reads them") {
    const std::string words("\x01\0\0\0", 4);
    refused(words, 1, 2, "found a NUL byte, expected assembly text");
    refused("NOP\n" + words, 2, 2, "`pxpl5 dis`");
}

TEST_CASE("the nearest name ignores upper and lower case, and is empty if none is near") {
    CHECK(isa::edit_distance("kitten", "sitting") == 3);
    CHECK(isa::edit_distance("ABC", "abc") == 0);
    CHECK(isa::edit_distance("", "abc") == 3);
    const std::vector<std::string_view> known = {"orbit", "zoom"};
    CHECK(isa::nearest("ZOON", known) == "zoom");
    CHECK(isa::nearest("xylophone", known).empty());
    CHECK(isa::nearest("orbit", {}).empty());
}

TEST_CASE("parameters are listed with their places") {
    const isa::Program program = isa::assemble("LOOP #$count\nCONSTintoMEM m0:8 $k\nENDLOOP");
    REQUIRE(program.patches.size() == 2);
    CHECK(program.patches[0] == isa::Program::Patch{"count", 0, true});
    CHECK(program.patches[1] == isa::Program::Patch{"k", 2, false});
}

TEST_CASE("random programs survive disassembly and assembly") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(41);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    for (int i = 0; i < 40; ++i) {
        const std::vector<std::uint32_t> words = random.program();
        CHECK(isa::assemble(isa::disassemble(words)).words == words);
    }
}

TEST_CASE("damaged text is refused or assembled, never a crash") {
    const std::uint64_t seed = test::seed_or<std::uint64_t>(42);
    INFO("PXPL5_SEED=", seed);
    test::RandomPrograms random(seed);
    std::string text = isa::disassemble(random.program());
    constexpr std::string_view bits = "$m[]:;#+-*x>0 9a\n\t\x80";
    std::size_t refusals = 0;
    for (int i = 0; i < 500; ++i) {
        std::string damaged = text;
        const auto size = static_cast<std::uint32_t>(damaged.size());
        damaged[random.below(size)] = bits[random.below(static_cast<std::uint32_t>(bits.size()))];
        try {
            isa::assemble(damaged);
        } catch (const isa::AssemblyError& error) {
            ++refusals;
            CHECK(error.line >= 1);
        }
    }
    CHECK(refusals > 100);
}

TEST_CASE("a listing numbers the words and shows what does not decode") {
    const std::vector<std::uint32_t> words = {0x01000000, 0xff000000, 0x21000008};
    CHECK(isa::disassemble(words, {.numbered = true}) ==
          "     0  01000000       1  SETENABS\n"
          "     1  ff000000       -  ; 0xff000000 is not an instruction\n"
          "     2  21000008       -  ; 0x21000008 has too few coefficient words\n");
}
