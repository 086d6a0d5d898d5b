// Command lines: a line that its command accepts is written again as a line of the same meaning.
#include <fmt/format.h>

#include "host/base/error.hpp"
#include "host/commands/command_options.hpp"
#include "host/commands/commands.hpp"
#include "host/commands/load_options.hpp"
#include "host/inspect/record/selection.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

namespace {

using host::Arguments;

bool same(const Arguments& a, const Arguments& b) {
    return a.name == b.name && a.words == b.words && a.options == b.options;
}

/// Each parser of a value on one text. An accepted value is in its range.
void check_values(const std::string& text) {
    const auto tried = [](const auto& parse) {
        try {
            parse();
        } catch (const host::RequestError& error) {
            require(error.code == host::ExitCode::usage, error.what());
        }
    };
    tried([&] {
        const double value = host::parse_number("v", text, -5, 5);
        require(value >= -5 && value <= 5, "a number in its range");
    });
    tried([&] {
        const int value = host::parse_whole("v", text, -5, 5);
        require(value >= -5 && value <= 5, "a whole number in its range");
    });
    tried([&] { host::parse_whole("v", text); });
    tried([&] { host::parse_triple("v", text, 0, 9); });
    tried([&] {
        const auto [x, y] = host::parse_pair("v", text);
        require(x >= 0 && y >= 0, "a pair in its range");
    });
    tried([&] {
        const host::Size size = host::parse_size(text, 1, 9);
        require(size.width >= 1 && size.width <= 9 && size.height >= 1 && size.height <= 9,
                "a size in its range");
    });
    tried([&] { host::parse_color(text); });
    tried([&] {
        host::inspect::SelectionText selection;
        selection.frame = selection.region = selection.slab = selection.op = {text};
        const auto chosen = host::inspect::parse_selection(selection);
        for (const host::inspect::Range& range : chosen.frames) {
            require(range.from <= range.to, "a range that is empty");
        }
    });
}

void check_line(const std::string& line) {
    const Arguments arguments = host::parse_line(line);
    if (!arguments.name.empty()) {
        const std::string again = host::to_line(arguments);
        require(same(host::parse_line(again), arguments),
                fmt::format("'{}' becomes '{}'", line, again));
    }
    const host::Command& command = host::find_command(arguments.name);
    host::check_arguments(command, arguments);
    host::subject_of(arguments);
    host::kind_of(arguments);
    if (command.name == "load") {
        const host::ImportOptions options = host::load_options(arguments);
        require(std::ranges::all_of(options.spacing_mm, [](double mm) { return mm > 0; }),
                "the spacing of load");
    }
}

}  // namespace

/// Input: 'l' and a line of a script; 'v' and a value; 'o' and the value of a long option, behind
/// the number of a command.
bool accepts(Input input) {
    Bytes bytes(input);
    const char kind = bytes.take<char>();
    if (kind == 'v') {
        check_values(bytes.text());
        return true;
    }
    try {
        if (kind == 'o') {
            const host::CommandTable table = host::command_table();
            const host::Command& command = table[bytes.take<std::uint8_t>() % table.size()];
            check_line(host::to_line(host::command_of_option(command, bytes.text())));
        } else {
            check_line(bytes.text());
        }
        return true;
    } catch (const host::RequestError& error) {
        require(*error.what() != 0, "an error without a text");
        return false;
    }
}

}  // namespace pxpl5::fuzz
