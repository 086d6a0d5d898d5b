#include <doctest/doctest.h>

#include <filesystem>

#include "host/base/error.hpp"
#include "host/base/text_table.hpp"
#include "host/inspect/map/picture_file.hpp"
#include "host/inspect/record/selection.hpp"
#include "host/inspect/replay/executors.hpp"
#include "host/inspect/tools/exec_fields.hpp"
#include "host/inspect/tools/program_files.hpp"
#include "host/inspect/tools/tools.hpp"
#include "isa/assemble.hpp"
#include "tests/host/inspect/tool_files.hpp"

using namespace pxpl5;
using namespace pxpl5::host::inspect;
using host::RequestError;
using test::content_of;
using test::Folder;
using test::selecting;

namespace {

/// Output and exit code of exec.
struct Executed {
    int code;
    std::string text;
};
Executed executed(const Folder& folder, const ExecOptions& options) {
    host::TextOutput output(folder.at("exec.txt"));
    const int code = execute(options, output);
    return {code, content_of(folder.at("exec.txt"))};
}

constexpr const char* ramp = "SETENABS\nTREEintoMEM m0:8 >>0 1 2 $start\n";

}  // namespace

TEST_CASE("a selection holds the numbers of its ranges, and all when it is not given") {
    const Selection s =
        selecting({{&SelectionText::frame, {"3-5 9", "12-"}}, {&SelectionText::gp, {"7,1"}}});
    for (const std::uint32_t in : {3U, 4U, 5U, 9U, 12U, 4'000'000'000U}) {
        CHECK(s.has_frame(in));
    }
    for (const std::uint32_t out : {0U, 2U, 6U, 8U, 10U, 11U}) {
        CHECK_FALSE(s.has_frame(out));
    }
    CHECK((s.has_gp(1) && s.has_gp(7) && !s.has_gp(0)));
    CHECK((s.has_renderer(0) && s.has_slab(77) && s.has_kind("Credit") && s.has_op(isa::Op::nop)));
}

TEST_CASE("a region is named by its number, or by column and row") {
    const Selection s = selecting({{&SelectionText::region, {"2,1 5"}}});
    CHECK(s.has_region(6, 2, 1));
    CHECK(s.has_region(5, 1, 1));
    CHECK_FALSE(s.has_region(6, 1, 2));
}

TEST_CASE("patterns select instructions and kinds of message") {
    const Selection s = selecting(
        {{&SelectionText::op, {"tree*", "MEM??MEM"}}, {&SelectionText::kind, {"Region*"}}});
    CHECK(s.has_op(isa::Op::tree_ge_zero));
    CHECK(s.has_op(isa::Op::mem_lt_mem));
    CHECK_FALSE(s.has_op(isa::Op::mem_into_mem));
    CHECK(s.has_kind("RegionPixels"));
    CHECK_FALSE(s.has_kind("FrameDone"));
}

TEST_CASE("a selection that can mean nothing is refused by option, text and what is expected") {
    CHECK_THROWS_WITH(selecting({{&SelectionText::frame, {"5-3"}}}),
                      "--frame '5-3'; it must be a range that ascends, e.g. 3-5");
    CHECK_THROWS_WITH(selecting({{&SelectionText::gp, {"x"}}}),
                      "--gp 'x'; it must be a number, or a range such as 3-5 or 3-");
    CHECK_THROWS_AS(selecting({{&SelectionText::frame, {"-3"}}}), RequestError);
    CHECK_THROWS_AS(selecting({{&SelectionText::slab, {"99999999999"}}}), RequestError);
    CHECK_THROWS_AS(selecting({{&SelectionText::region, {"1,2,3"}}}), RequestError);
    CHECK_THROWS_AS(selecting({{&SelectionText::region, {"a"}}}), RequestError);
    CHECK_THROWS_AS(selecting({{&SelectionText::op, {"TREX*"}}}), RequestError);
    CHECK_THROWS_AS(selecting({{&SelectionText::kind, {"NONE"}}}), RequestError);
}

TEST_CASE("words go through binary and hexadecimal text unchanged") {
    const std::vector<std::uint32_t> words =
        isa::assemble("SETENABS\nTREEgeZERO :24 3 -5 120\nQUADgeZERO :9 1 2 3 4 5 6\nNOP\n").words;
    CHECK(parse_words("b", binary_of(words), WordFormat::detect) == words);
    CHECK(parse_words("h", hex_of(words), WordFormat::detect) == words);
    CHECK(binary_of({0x04030201}) == std::string("\x01\x02\x03\x04"));
    // Words whose bytes are all digits: told to be binary, they are.
    CHECK(parse_words("d", "00000000", WordFormat::binary) ==
          std::vector<std::uint32_t>{0x30303030, 0x30303030});
    CHECK(parse_words("d", "0x10 ; 99\n11", WordFormat::detect) ==
          std::vector<std::uint32_t>{0x10, 0x11});
    CHECK_THROWS_WITH(parse_words("f", std::string("\x01\x02\x03", 3), WordFormat::detect),
                      "f: 3 bytes are no whole number of 4-byte words");
    CHECK_THROWS_WITH(parse_words("f", "12\n123456789", WordFormat::hex),
                      "f: line 2: '123456789' is no hexadecimal word of 32 bits");
}

TEST_CASE("asm and dis turn a file into words and back") {
    const Folder folder;
    const std::string text = "SETENABS\nTREEgeZERO :24  3 -5 120\nIMMintoMEM m0:8 #7\n";
    assemble_tool({.file = folder.write("p.pxasm", text), .output = folder.at("p.bin")});
    CHECK(content_of(folder.at("p.bin")).size() == 4 * 6);
    CHECK(disassemble_tool({.file = folder.at("p.bin"), .output = folder.at("q")}) == 0);
    CHECK(content_of(folder.at("q")) == text);
    assemble_tool({.file = folder.at("p.pxasm"), .output = folder.at("p.hex"), .hex = true});
    disassemble_tool({.file = folder.at("p.hex"), .output = folder.at("r")});
    CHECK(content_of(folder.at("r")) == text);
}

TEST_CASE("a file that is no program is refused by name and place") {
    const Folder folder;
    const auto assemble = [&](const std::string& text) {
        assemble_tool({.file = folder.write("bad.pxasm", text), .output = folder.at("x")});
    };
    CHECK_THROWS_WITH_AS(assemble("SETENABS\nSETENAB\n"), doctest::Contains("bad.pxasm: line 2"),
                         RequestError);
    CHECK_THROWS_WITH_AS(assemble(ramp), doctest::Contains("start"), RequestError);
    CHECK_THROWS_WITH_AS(assemble("ENDLOOP\n"), doctest::Contains("bad.pxasm: word 0"),
                         RequestError);
    CHECK_THROWS_WITH_AS(assemble_tool({.file = folder.at("absent")}), doctest::Contains("absent"),
                         RequestError);
    folder.write("w", "ffffffff\n01000000");
    CHECK_THROWS_WITH_AS(disassemble_tool({.file = folder.at("w"), .output = folder.at("y")}),
                         doctest::Contains("1 of 2 words"), RequestError);
    CHECK(content_of(folder.at("y")).find("SETENABS") != std::string::npos);
}

TEST_CASE("exec prints the fields of pixels that a program has made") {
    const Folder folder;
    const std::string program = folder.write("ramp.pxasm", ramp);
    for (const char* executor : {"reference", "fast"}) {
        const Executed table = executed(folder, {.programs = {program},
                                                 .parameters = {"start=-3"},
                                                 .prints = {"m0:8"},
                                                 .executor = executor,
                                                 .window = "0..2,0..1"});
        CHECK(table.code == 0);
        // x + 2 y - 3, modulo 256.
        CHECK(table.text.find("m0:8\ny\\x    0    1    2\n  0  253  254  255\n  1  255    0    "
                              "1\n") != std::string::npos);
        // SETENABS takes 1 cycle, TREEintoMEM b + n + 4 = 12.
        CHECK(table.text.find("2 instructions, 13 cycles") != std::string::npos);
        CHECK(table.text.find("16,384 of 16,384 pixels enabled") != std::string::npos);
    }
    const Executed pixel = executed(folder, {.programs = {program},
                                             .parameters = {"start=-3"},
                                             .prints = {"m0:8", "enable"},
                                             .pixel = "0,1",
                                             .is_signed = true});
    CHECK(pixel.text.find("pixel (0, 1)\n  m0:8       -1\n  enable     1\n") != std::string::npos);
}

TEST_CASE("exec begins with the state that --init gives, and runs files one after the other") {
    const Folder folder;
    const std::string add = folder.write("a", "MEMpluseqCONST m0:8 1\n");
    const std::string twice = folder.write("b", "MEMpluseqMEM m0:8 m0\n");
    const Executed done = executed(folder, {.programs = {add, twice},
                                            .init = {"m0:8=3*x", "enable@1..2,0=1"},
                                            .prints = {"m0:8"},
                                            .executor = "both",
                                            .window = "0..3,0"});
    CHECK(done.text.find("\n  0  0  8  14  9\n") != std::string::npos);
    CHECK(done.text.find("reference and fast agree on all pixels") != std::string::npos);
    CHECK_THROWS_AS(executed(folder, {.programs = {add}, .init = {"m0:8"}}), RequestError);
    CHECK_THROWS_AS(executed(folder, {.programs = {add}, .init = {"z=q"}}), RequestError);
}

TEST_CASE("exec runs a conformance case, and fails if it is not as expected") {
    const Folder folder;
    const std::string text =
        "title  One and one\ngiven m0:8 enable\n  all 1 1\nrun\n  MEMpluseqCONST m0:8 1\n"
        "expect m0:8 carry\n  all ";
    CHECK(executed(folder, {.programs = {folder.write("a.pxt", text + "2 0\n")}}).code == 0);
    const Executed bad = executed(folder, {.programs = {folder.write("b.pxt", text + "3 0\n")}});
    CHECK(bad.code == static_cast<int>(host::ExitCode::failed));
    CHECK(bad.text.find("'One and one' is not as expected") != std::string::npos);
}

TEST_CASE("a program that stops early is a failure that says where") {
    const Folder folder;
    const Executed done = executed(folder, {.programs = {folder.write("r", "RET\n")}});
    CHECK(done.code == static_cast<int>(host::ExitCode::failed));
    CHECK(done.text.find("stopped: ") != std::string::npos);
}

TEST_CASE("fields are named by layout or by place, and refused beyond the memory") {
    CHECK(parse_field("z").column == isa::StateColumn{isa::StateColumn::Kind::field, 8, 24});
    CHECK(parse_field("z:8").column == isa::StateColumn{isa::StateColumn::Kind::field, 8, 8});
    CHECK(parse_field("m200:8").column == isa::StateColumn{isa::StateColumn::Kind::field, 200, 8});
    CHECK(parse_field("bs3").column == isa::StateColumn{isa::StateColumn::Kind::block, 3, 32});
    for (const char* bad : {"m200:9", "m208:1", "m0:65", "m0:0", "zz", "bs128", "m:4", ""}) {
        CHECK_THROWS_AS(parse_field(bad), RequestError);
    }
    CHECK_THROWS_AS(parse_window("0..128,0"), RequestError);
    CHECK_THROWS_AS(parse_window("5..3,0"), RequestError);
    CHECK(parse_window("*,7") == isa::PixelRectangle{0, 7, 127, 7});
}

TEST_CASE("a picture of a field is black at its least value and white at its greatest") {
    const auto executor = make_executor(ExecutorKind::fast);
    executor->execute({isa::Op::set_enabs, {}}, {});
    const std::int32_t plane[] = {1, 0, 10};
    executor->execute({isa::Op::tree_into_mem, {0, 0, 8}}, plane);
    const FieldPicture picture = field_picture({*executor, {}}, parse_field("m0:8"));
    CHECK(picture.legend == "m0:8: black is 10, white is 137");
    CHECK(picture.rgba.at(0) == 0xFF000000);
    CHECK(picture.rgba.at(127) == 0xFFFFFFFF);
    CHECK(picture.rgba.at(128 * 127) == 0xFF000000);
    CHECK_THROWS_AS(field_picture({*executor, {}}, parse_field("readout")), RequestError);
}

TEST_CASE("a picture of a field that has one value everywhere comes with a warning") {
    const auto executor = make_executor(ExecutorKind::fast);
    CHECK(field_picture({*executor, {}}, parse_field("rgb")).warning ==
          "rgb is 0 at every pixel; no instruction stored a value into bits 64 to 87 of an enabled "
          "pixel");
    executor->execute({isa::Op::set_enabs, {}}, {});
    const std::int32_t plane[] = {1, 0, 10};
    executor->execute({isa::Op::tree_into_mem, {64, 0, 24}}, plane);
    CHECK(field_picture({*executor, {}}, parse_field("rgb")).warning.empty());
}

TEST_CASE("a picture is written under the name of a PNG file only, refused before anything runs") {
    const Folder folder;
    ExecOptions options;
    options.programs = {folder.at("no-such-program.pxasm")};
    options.picture = "rgb";
    options.output = folder.at("r.jpg");
    CHECK_THROWS_WITH_AS(executed(folder, options), doctest::Contains("only PNG files"),
                         RequestError);
    CHECK_THROWS_AS(write_png(options.output, 1, 1, std::vector<std::uint32_t>(1)), RequestError);
    CHECK_FALSE(std::filesystem::exists(options.output));
}

TEST_CASE("a PNG file states its size, and names the reason if it cannot be written") {
    const Folder folder;
    const std::vector<std::uint32_t> pixels(6, 0xFF0000FF);
    write_png(folder.at("p.png"), 3, 2, pixels);
    const std::string png = content_of(folder.at("p.png"));
    CHECK(png.substr(0, 8) == "\x89PNG\r\n\x1a\n");
    CHECK(png.substr(16, 8) == std::string("\0\0\0\x03\0\0\0\x02", 8));
    CHECK_THROWS_WITH_AS(write_png(folder.at("no/p.png"), 3, 2, pixels),
                         doctest::Contains("no/p.png"), RequestError);
}

TEST_CASE("a table's columns are as wide as what they hold") {
    CHECK(host::text_table({"a", "bb"}, {{"ccc", "1"}, {"d", "222"}}) ==
          "a     bb\nccc    1\nd    222\n");
}
