#include <doctest/doctest.h>

#include <string>

#include "host/base/command_line.hpp"
#include "host/base/error.hpp"
#include "host/base/nearest.hpp"
#include "host/base/prompt.hpp"
#include "host/commands/commands.hpp"

using namespace pxpl5::host;

namespace {

/// The text of the RequestError that `act` throws; empty if it throws none.
template <typename Act>
std::string error_of(Act act) {
    try {
        act();
    } catch (const RequestError& error) {
        return error.what();
    }
    return {};
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_SUITE("host/command_line") {
    TEST_CASE("a line is a name, words and options in any order") {
        const Arguments a = parse_line("surface  bone iso=300.5 'my name' color=#ff0080 # end");
        CHECK(a.name == "surface");
        CHECK(a.words == std::vector<std::string>{"bone", "my name"});
        CHECK(a.text("iso", "") == "300.5");
        CHECK(a.text("color", "") == "#ff0080");
        CHECK(a.options.size() == 2);
    }

    TEST_CASE("quotes keep blanks and equals signs") {
        const Arguments a = parse_line("load \"a b=c.nii\"");
        CHECK(a.words == std::vector<std::string>{"a b=c.nii"});
        CHECK(a.options.empty());
    }

    TEST_CASE("whatever is in a word or an option survives being made into a line") {
        Arguments arguments{"snapshot",
                            {"a b", "it's", "\"both\" 'kinds'", "x;quit\ny", "#", "k=v", ""},
                            {{"iso", "5;quit"}, {"color", "#ffffff"}}};
        const Arguments back = parse_line(to_line(arguments));
        CHECK(back.name == arguments.name);
        CHECK(back.words == arguments.words);
        CHECK(back.options == arguments.options);
    }

    TEST_CASE("names and keys with blanks and equals signs survive being made into a line") {
        const Arguments arguments{"a b", {}, {{"k=1 x", "y"}, {"#", "z"}}};
        const Arguments back = parse_line(to_line(arguments));
        CHECK(back.name == arguments.name);
        CHECK(back.words.empty());
        CHECK(back.options == arguments.options);
    }

    TEST_CASE("blank lines and comments are nothing") {
        CHECK(parse_line("   ").name.empty());
        CHECK(parse_line("# all of it").name.empty());
    }

    TEST_CASE("a line that is written again has no character of a shell outside of quotes") {
        for (const std::string word :
             {"$(touch x)", "a;b", "`x`", "a|b", "a&b", "a>b", "*", "~", "a'$x'b"}) {
            CAPTURE(word);
            Arguments arguments;
            arguments.name = "surface";
            arguments.words = {word};
            const std::string line = to_line(arguments);
            CHECK(parse_line(line).words == arguments.words);
            char quote = 0;
            for (const char c : line) {
                if (quote == 0) {
                    CHECK(std::string_view("$`|&;<>()*?~!{}[]\\").find(c) ==
                          std::string_view::npos);
                }
                if (c == '\'' || c == '"') {
                    quote = quote == 0 ? c : quote == c ? '\0' : quote;
                }
            }
        }
        Arguments plain;
        plain.name = "load";
        plain.words = {"/data/scan-1.nrrd", "100%", "Schädel"};
        CHECK(to_line(plain) == "load /data/scan-1.nrrd 100% Schädel");
    }
    TEST_CASE("an open quote and a repeated key are refused by name") {
        CHECK(contains(error_of([] { parse_line("load 'abc"); }), "not closed"));
        CHECK(contains(error_of([] { parse_line("surface b iso=1 iso=2"); }), "'iso'"));
    }

    TEST_CASE("a NUL byte is refused: paths and errors would end there") {
        CHECK(error_of([] { parse_line(std::string_view("snapshot '\0/x.png'", 18)); }) ==
              "byte 11 of the command is a NUL; a command must be text");
    }

    TEST_CASE("numbers are whole, finite and in range, and the error names both values") {
        CHECK(parse_number("zoom", "1.5e1", 0, 20) == 15);
        CHECK(contains(error_of([] { parse_number("zoom", "12px", 0, 20); }), "'12px'"));
        CHECK(contains(error_of([] { parse_number("zoom", "nan", 0, 20); }), "nan"));
        CHECK(error_of([] { parse_number("zoom", "1e400", 0, 20); }) ==
              "zoom: '1e400' is too large or too small for a number");
        const std::string range = error_of([] { parse_number("zoom", "21", 0, 20); });
        CHECK(contains(range, "zoom: 21 is outside 0 .. 20"));
    }

    TEST_CASE("sizes and colors") {
        CHECK(parse_size("640x480", 1, 4096).width == 640);
        CHECK(parse_size("640x480", 1, 4096).height == 480);
        CHECK(contains(error_of([] { parse_size("640", 1, 4096); }), "'640'"));
        CHECK(contains(error_of([] { parse_size("1x9999", 1, 4096); }), "9999"));
        CHECK(error_of([] { parse_size("0x7", 1, 4096); }) ==
              "size: width: 0 is outside 1 .. 4096");
        CHECK(parse_color("#010203").b == 3);
        CHECK(parse_color("1,2,255").g == 2);
        CHECK(parse_color("white").r == 255);
        CHECK(contains(error_of([] { parse_color("boned"); }), "did you mean 'bone'"));
    }

    TEST_CASE("the nearest name is offered where one is near, else all are listed") {
        const std::string_view names[] = {"orbit", "light"};
        CHECK(nearest("orbot", names) == "orbit");
        CHECK(did_you_mean("ligth", names) == "; did you mean 'light'?");
        CHECK(did_you_mean("orb", names) == "; did you mean 'orbit'?");
        const std::string_view ours[] = {"--scale", "--iso", "anterior"};
        CHECK(did_you_mean("front", ours) == "; did you mean 'anterior'?");
        CHECK(did_you_mean("--isovalue", ours) == "; did you mean '--iso'?");
        CHECK(did_you_mean("orbit", names) == "; known: orbit, light");
        CHECK(did_you_mean("zzzzzzzz", names) == "; known: orbit, light");
    }
}

TEST_SUITE("host/commands") {
    TEST_CASE("every command of the table is found by its name and has help") {
        for (const Command& command : command_table()) {
            CHECK(&find_command(command.name) == &command);
            CHECK(!command.help.empty());
            CHECK(command.help.back() == '.');
            CHECK(command.required <= command.words.size());
        }
    }

    TEST_CASE("an unknown command is refused with the nearest name") {
        CHECK(contains(error_of([] { find_command("snapshit"); }), "did you mean 'snapshot'"));
    }
}

TEST_CASE("semicolons and newlines separate commands outside quotes and comments") {
    const auto commands = [](const std::string& text) {
        std::string joined;
        const LineSource next = lines_of_text(text);
        for (std::optional<std::string> command; (command = next());) {
            joined += "[" + *command + "]";
        }
        return joined;
    };
    CHECK(commands("") == "[]");
    CHECK(commands("a;b\nc;") == "[a][b][c][]");
    CHECK(commands("a 'x;y' \"p\nq\";b") == "[a 'x;y' \"p\nq\"][b]");
    CHECK(commands("a # b; c\nd") == "[a # b; c][d]");
    CHECK(commands("a;# b; c") == "[a][# b; c]");
    CHECK(commands("a #") == "[a #]");
    CHECK(commands("a #ff0000;b# c;d") == "[a #ff0000][b# c][d]");
    CHECK(commands("a '# b';c") == "[a '# b'][c]");
}
