#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "host/base/error.hpp"
#include "host/inspect/step/step_program.hpp"
#include "host/inspect/step/step_view.hpp"
#include "tests/host/inspect/recorded_sphere.hpp"

using namespace pxpl5;
namespace inspect = host::inspect;

namespace {

/// A ball over two regions of 128 x 128; (100, 64) is on it, (3, 3) is not.
const inspect::RecordedRun& ball() {
    static const inspect::RecordedRun run = test::TracedSphere({200, 128}, 3, 2).run();
    return run;
}

inspect::StepProgram program() {
    return {ball(), 0, {.columns = 64}};
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

/// Runs commands and returns the last answer.
std::string answer(inspect::StepProgram& step, const std::vector<std::string>& commands) {
    std::string text;
    for (const std::string& command : commands) {
        text = step.command(command);
    }
    return text;
}

}  // namespace

TEST_CASE("a step tells address, instruction, enables and what changed") {
    inspect::StepProgram step = program();
    CHECK(contains(step.welcome(), "prologue+0"));
    const std::string first = step.command("s");
    CHECK(contains(first, "#0 "));
    CHECK(contains(first, "prologue+0"));
    CHECK(contains(first, "SETENABS"));
    CHECK(contains(first, "enabled 0 -> 16384"));
    CHECK_FALSE(contains(first, "changed"));
    const std::string second = step.command("s");
    CHECK(contains(second, "CONSTintoMEM m0:32"));
    CHECK(contains(second, "changed: z of 16384 pixels"));
    CHECK(step.stepper().place().executed == 2);
    CHECK(contains(step.command("b"), "next #1 "));
    CHECK(contains(step.command("s 3"), "#3 "));
    CHECK(contains(answer(step, {"b 3", "b 5"}), "the run begins here"));
}

TEST_CASE("a primitive's steps go from SETENABS to SETENABS, both ways") {
    inspect::StepProgram step = program();
    const std::string first = step.command("t");
    CHECK(contains(first, "SETENABS"));
    CHECK(contains(first, "gp-"));
    const std::uint64_t at = step.stepper().place().executed;
    step.command("t 2");
    CHECK(step.stepper().place().executed == at + 20);  // Ten instructions each.
    step.command("s 4");
    step.command("T");
    CHECK(step.stepper().place().executed == at + 20);
    CHECK(step.command("T 2") == first);
}

TEST_CASE("goto finds instructions, addresses, regions and pixels") {
    inspect::StepProgram step = program();
    CHECK(contains(step.command("goto 17"), "#17 "));
    CHECK(contains(step.command("goto end+0"), "end+0"));
    CHECK(contains(step.command("goto 1+34"), "SETENABS"));
    CHECK(contains(step.command("goto end"), "region 0 of frame 0 is drawn"));
    step.command("goto pixel 150 5");
    CHECK(step.stepper().place().region == 1);
    step.command("goto region 0,0");
    CHECK(step.stepper().place().region == 0);
    CHECK_THROWS_AS(step.command("goto region 5"), host::RequestError);
    CHECK_THROWS_AS(step.command("goto nowhere+3"), host::RequestError);
    CHECK_THROWS_AS(step.command("goto frame 9"), host::RequestError);
    const renderer::RegionPlan& plan = step.stepper().region().plan;
    for (std::size_t part = 0; part < plan.parts.size(); ++part) {
        const inspect::Address address{part, 0};
        CHECK(inspect::address_of(plan, inspect::to_text(plan, address)) == address);
    }
}

TEST_CASE("breakpoints are made, held, listed and removed") {
    inspect::StepProgram step = program();
    CHECK_THROWS_AS(step.command("c"), host::RequestError);
    CHECK(step.command("break op pixelsto*") == "breakpoint 1: op pixelsto*");
    CHECK(contains(step.command("c"), "PIXELSTOFB"));
    step.command("delete 1");
    CHECK(step.command("break pixel 100 64") == "breakpoint 2: pixel 100 64 written");
    step.command("goto end+0");
    const std::string wrote = step.command("rc");
    CHECK(contains(wrote, "breakpoint 2"));
    CHECK(contains(wrote, "IMMintoMEM m0:8"));  // The last instruction of a triangle.
    CHECK(contains(step.command("info"), "2: pixel 100 64 written"));
    CHECK(step.command("delete") == "no breakpoint is left");
    CHECK(step.command("info") == "no breakpoint");
    step.command("break z 100 64 < 16777215");
    CHECK(contains(answer(step, {"goto 0", "c"}), "TREEintoMEM m8:24"));
    CHECK(contains(step.command("pixel 100 64"), "enable     1"));
    CHECK(contains(step.command("print enable 100 64 1 1"), " 1*"));  // Its triangle is small.
    CHECK(contains(step.command("print enable 64 100 1 1"), " 0 "));
    for (const char* wrong : {"break", "break op", "break pixel 1", "break z 1 1 > 5",
                              "break cell 1,2", "break pixel 500 500", "break at end+9999"}) {
        CAPTURE(wrong);
        CHECK_THROWS_AS(step.command(wrong), host::RequestError);
    }
}

TEST_CASE("pixel and print show what the executor holds") {
    inspect::StepProgram step = program();
    step.command("goto end+0");
    const auto& executor = step.stepper().here().executor();
    const std::uint64_t z = executor.field(100, 64, 8, 24);
    REQUIRE(z < isa::region::z_far);
    CHECK(contains(step.command("pixel 100 64"), fmt::format("z          {}\n", z)));
    CHECK(contains(step.command("pixel 3 3"), "surface    0 (background)"));
    const std::vector<std::string> lines = lines_of(step.command("print z 100 64 2 3"));
    REQUIRE(lines.size() == 5);  // A title, columns, three rows.
    CHECK(contains(lines[1], " 101"));
    CHECK(contains(lines[2], fmt::format("{}", z)));
    CHECK(contains(lines[4], fmt::format("{}", executor.field(101, 66, 8, 24))));
    CHECK_THROWS_AS(step.command("pixel 150 5"), host::RequestError);
    CHECK_THROWS_AS(step.command("print depth"), host::RequestError);
    CHECK(inspect::field_of("8:24").address == 8);
    CHECK_THROWS_AS(inspect::field_of("200:9"), host::RequestError);
    CHECK_THROWS_AS(inspect::field_of("8:65"), host::RequestError);
}

TEST_CASE("list marks the next instruction") {
    inspect::StepProgram step = program();
    const std::vector<std::string> lines = lines_of(answer(step, {"goto 1+1", "list 2"}));
    const auto marked = std::ranges::count_if(lines, [](const auto& l) { return l[0] == '='; });
    CHECK(marked == 1);
    REQUIRE(lines.size() == 4);  // One instruction is before it.
    CHECK(contains(lines[1], "TREEgeZERO"));
    CHECK(lines[1].starts_with("=>"));
}

TEST_CASE(
    "the picture in the terminal has the terminal's width, and light where the field is set") {
    inspect::StepProgram step = program();
    const std::vector<std::string> lines = lines_of(answer(step, {"goto end+0", "show surface"}));
    REQUIRE(lines.size() == 33);  // 64 columns: two pixels a letter, four pixels a line.
    CHECK(lines[0].size() == 64);
    CHECK(lines[16][50] != ' ');  // (100, 64)
    CHECK(lines[0][1] == ' ');    // (2, 0)
    const std::vector<std::uint32_t> two = {0xFF0000FF, 0xFF00FF00, 0xFFFF0000, 0xFFFFFFFF};
    CHECK(inspect::terminal_text(two, 2, {.columns = 80, .color = true}) ==
          "\x1b[38;2;255;0;0m\x1b[48;2;0;0;255m\u2580\x1b[38;2;0;255;0m"
          "\x1b[48;2;255;255;255m\u2580\x1b[0m\n");
}

TEST_CASE("help names every command, and each of them is one") {
    inspect::StepProgram step = program();
    const std::string help = step.command("help");
    for (const char* name : {"s",     "b",    "t",    "T",     "part",   "region", "frame",
                             "c",     "rc",   "goto", "break", "delete", "info",   "pixel",
                             "print", "show", "png",  "list",  "where",  "quit"}) {
        CAPTURE(name);
        CHECK(contains("\n" + help, fmt::format("\n  {} ", name)));
    }
    CHECK_THROWS_AS(step.command("jump"), host::RequestError);
    CHECK_THROWS_AS(step.command("s many"), host::RequestError);
    CHECK(step.command("  ").empty());
    CHECK(inspect::StepProgram::is_move("t 3"));
    CHECK_FALSE(inspect::StepProgram::is_move("where"));
    CHECK(contains(step.command("where"), "renderer-"));
    CHECK_FALSE(step.is_over());
    step.command("quit");
    CHECK(step.is_over());
}
