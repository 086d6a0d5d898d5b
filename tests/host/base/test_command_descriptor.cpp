// Descriptors: usage lines, help, checks of words, options and outputs.
#include <doctest/doctest.h>
#include <fmt/core.h>

#include <array>
#include <filesystem>

#include "host/base/command_descriptor.hpp"
#include "host/base/error.hpp"

using namespace pxpl5::host;

namespace {

constexpr std::array<std::string_view, 2> yes_no = {"yes", "no"};
constexpr std::array<std::string_view, 1> png = {".png"};

CommandDescriptor haze() {
    return {.name = "haze",
            .help = "Sets the haze.",
            .words = {{"NAME", "NAME", "a name"}, output_value("FILE", png, "picture")},
            .required = 1,
            .options = {number_value("depth", "MM", 0, 4, "depth of the haze", "mm"),
                        whole_value("steps", "N", 1, 9, "steps", "3"),
                        choice_value("on", yes_no, "switch", "yes")}};
}

/// The error for the line; empty if there is none.
std::string error_of(const std::string& line) {
    try {
        check_arguments(haze(), parse_line(line));
    } catch (const RequestError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("usage and help derive from words and options") {
    CHECK(usage_of(haze()) == "haze NAME [FILE] [depth=MM] [steps=N] [on=yes|no]");
    const std::string help = full_help(haze());
    CHECK(help.find("depth=MM         depth of the haze (0 to 4 mm)") != std::string::npos);
    CHECK(help.find("steps=N          steps (1 to 9; default 3)") != std::string::npos);
    const std::string json = json_text(descriptor_fields(haze()));
    CHECK(json.find("\"name\":\"depth\",\"form\":\"MM\",\"type\":\"number\"") != std::string::npos);
}

TEST_CASE("words and options are checked by the descriptor") {
    CHECK(error_of("haze a").empty());
    CHECK(error_of("haze a depth=4 steps=9 on=no").empty());
    CHECK(error_of("haze").starts_with("haze takes 1 to 2 words, but 0 are given; usage: haze"));
    CHECK(error_of("haze a depth=5") == "haze: depth: 5 is outside 0 .. 4");
    CHECK(error_of("haze a steps=1.5") == "haze: steps: '1.5' is not a whole number");
    CHECK(error_of("haze a on=yse") == "haze: on cannot be 'yse'; did you mean 'yes'?");
    CHECK(error_of("haze a dept=1") == "haze has no option 'dept'; did you mean 'depth'?");
    CHECK(error_of("haze a --depth 3").find("write depth=3, not --depth 3") != std::string::npos);
}

TEST_CASE("an output is refused for its suffix or its folder before anything is done") {
    const std::string folder = std::filesystem::temp_directory_path().string();
    CHECK(error_of("haze a " + folder + "/x.png").empty());
    CHECK(error_of("haze a " + folder + "/x.jpg").find("must end in .png") != std::string::npos);
    CHECK(error_of("haze a /no/such/x.png").find("does not exist") != std::string::npos);
}

TEST_CASE("a name is found by alias, and an unknown name with the nearest") {
    std::array<CommandDescriptor, 1> table = {haze()};
    table[0].aliases = {"h"};
    const std::span<const CommandDescriptor> commands = table;
    CHECK(find_in(commands, "h").name == "haze");
    CHECK_THROWS_WITH_AS(find_in(commands, "hase"), doctest::Contains("did you mean 'haze'?"),
                         RequestError);
}
