#include "host/base/command_line.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <optional>

#include "host/base/error.hpp"
#include "host/base/nearest.hpp"

namespace pxpl5::host {

namespace {

/// A word and the place of its first '=' outside quotes.
struct Word {
    std::string text;
    std::size_t equals = std::string::npos;
};

/// Reads one word at `at`, which is not a blank, and moves `at` behind it.
Word read_word(std::string_view line, std::size_t& at) {
    Word word;
    char quote = 0;
    for (; at < line.size() && (quote != 0 || (line[at] != ' ' && line[at] != '\t')); ++at) {
        const char c = line[at];
        if (quote != 0 && c == quote) {
            quote = 0;
        } else if (quote == 0 && (c == '"' || c == '\'')) {
            quote = c;
        } else {
            if (quote == 0 && c == '=' && word.equals == std::string::npos) {
                word.equals = word.text.size();
            }
            word.text += c;
        }
    }
    if (quote != 0) {
        refuse_command(fmt::format("the quote {} is not closed in: {}", quote, line));
    }
    return word;
}

/// Returns whether no shell gives the character a meaning, so that a saved script starts no
/// program if a user runs it by a shell.
bool is_plain(char c) {
    constexpr std::string_view marks = "_./:,+-%@";
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalnum(byte) != 0 || marks.find(c) != std::string_view::npos;
}

/// The word, in quotes where it needs them; a quote itself goes into the other kind.
std::string quoted(const std::string& word) {
    if (!word.empty() && std::ranges::all_of(word, is_plain)) {
        return word;
    }
    std::string text = "'";
    for (const char c : word) {
        text += c == '\'' ? "'\"'\"'" : std::string(1, c);
    }
    return text + "'";
}

struct NamedColor {
    std::string_view name;
    Color color;
};
constexpr std::array named_colors = {
    NamedColor{"white", {255, 255, 255}}, NamedColor{"gray", {160, 160, 160}},
    NamedColor{"red", {214, 72, 62}},     NamedColor{"green", {96, 176, 96}},
    NamedColor{"blue", {86, 130, 210}},   NamedColor{"yellow", {226, 200, 90}},
    NamedColor{"bone", {236, 226, 200}},  NamedColor{"skin", {224, 172, 140}},
    NamedColor{"muscle", {186, 88, 80}},  NamedColor{"brain", {222, 182, 178}},
};

std::optional<Color> hex_color(std::string_view text) {
    std::uint32_t value = 0;
    if (text.size() != 7 || text[0] != '#' ||
        std::from_chars(text.data() + 1, text.data() + 7, value, 16).ptr != text.data() + 7) {
        return std::nullopt;
    }
    const auto byte = [value](unsigned shift) {
        return static_cast<std::uint8_t>((value >> shift) & 255U);
    };
    return Color{byte(16), byte(8), byte(0)};
}

}  // namespace

void refuse_command(const std::string& text) {
    throw RequestError(ExitCode::usage, text);
}

std::string Arguments::text(std::string_view key, std::string_view otherwise) const {
    const auto found = options.find(std::string(key));
    return found == options.end() ? std::string(otherwise) : found->second;
}

double Arguments::number(std::string_view key, double otherwise) const {
    return has(key) ? parse_number(key, text(key, "")) : otherwise;
}

Arguments parse_line(std::string_view line) {
    while (line.ends_with('\r')) {
        line.remove_suffix(1);  // Of a script with the line ends of Windows.
    }
    // The system's calls and the errors' texts would end there.
    if (const std::size_t nul = line.find('\0'); nul != std::string_view::npos) {
        refuse_command(
            fmt::format("byte {} of the command is a NUL; a command must be text", nul + 1));
    }
    Arguments arguments;
    for (std::size_t at = 0; at < line.size();) {
        if (line[at] == ' ' || line[at] == '\t' || line[at] == '\r') {
            ++at;
            continue;
        }
        // "#ff8000" is a color, "# words" a comment.
        if (begins_comment(line.substr(at))) {
            break;
        }
        const Word word = read_word(line, at);
        if (arguments.name.empty()) {
            arguments.name = word.text;
        } else if (word.equals == std::string::npos || word.equals == 0) {
            arguments.words.push_back(word.text);
        } else if (!arguments.options
                        .emplace(word.text.substr(0, word.equals),
                                 word.text.substr(word.equals + 1))
                        .second) {
            refuse_command(fmt::format("'{}' is given twice", word.text.substr(0, word.equals)));
        }
    }
    return arguments;
}

std::string to_line(const Arguments& arguments) {
    std::string line = quoted(arguments.name);
    for (const std::string& word : arguments.words) {
        line += " " + quoted(word);
    }
    for (const auto& [key, value] : arguments.options) {
        line += " " + quoted(key) + "=" + quoted(value);
    }
    return line;
}

double parse_number(std::string_view what, std::string_view text, double low, double high) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range) {
        refuse_command(fmt::format("{}: '{}' is too large or too small for a number", what, text));
    }
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
        refuse_command(fmt::format("{}: '{}' is not a number", what, text));
    }
    if (value < low || value > high) {
        refuse_command(fmt::format("{}: {} is outside {} .. {}", what, text, low, high));
    }
    return value;
}

int parse_whole(std::string_view what, std::string_view text, int low, int high) {
    const double value = parse_number(what, text, low, high);
    if (value != std::floor(value)) {
        refuse_command(fmt::format("{}: '{}' is not a whole number", what, text));
    }
    return static_cast<int>(value);
}

glm::dvec3 parse_triple(std::string_view what, std::string_view text, double low, double high) {
    const char separator = text.find(',') != std::string_view::npos ? ',' : 'x';
    const std::size_t first = text.find(separator), second = text.rfind(separator);
    if (first == second) {
        refuse_command(fmt::format("{}: '{}' is not three numbers, as 1,2,3", what, text));
    }
    return {parse_number(what, text.substr(0, first), low, high),
            parse_number(what, text.substr(first + 1, second - first - 1), low, high),
            parse_number(what, text.substr(second + 1), low, high)};
}

std::pair<int, int> parse_pair(std::string_view what, std::string_view text) {
    const std::size_t comma = text.find(',');
    if (comma == std::string_view::npos) {
        refuse_command(fmt::format("{}: '{}' is not two numbers, as 120,80", what, text));
    }
    constexpr int most = 1 << 20;
    return {parse_whole(what, text.substr(0, comma), 0, most),
            parse_whole(what, text.substr(comma + 1), 0, most)};
}

Size parse_size(std::string_view text, int low, int high) {
    const std::size_t x = text.find('x');
    if (x == std::string_view::npos) {
        refuse_command(fmt::format("size: '{}' is not of the form WIDTHxHEIGHT", text));
    }
    const double width = parse_number("size: width", text.substr(0, x), low, high);
    const double height = parse_number("size: height", text.substr(x + 1), low, high);
    if (width != std::floor(width) || height != std::floor(height)) {
        refuse_command(fmt::format("size: '{}' is not in whole pixels", text));
    }
    return {static_cast<int>(width), static_cast<int>(height)};
}

Color parse_color(std::string_view text) {
    if (const auto color = hex_color(text)) {
        return *color;
    }
    std::vector<std::string_view> names;
    for (const NamedColor& named : named_colors) {
        if (named.name == text) {
            return named.color;
        }
        names.push_back(named.name);
    }
    const std::size_t first = text.find(','), second = text.rfind(',');
    if (first == second) {
        refuse_command(fmt::format("color: '{}' is not #rrggbb, r,g,b or a name{}", text,
                                   did_you_mean(text, names)));
    }
    const auto part = [](std::string_view number) {
        return static_cast<std::uint8_t>(parse_number("color", number, 0, 255));
    };
    return {part(text.substr(0, first)), part(text.substr(first + 1, second - first - 1)),
            part(text.substr(second + 1))};
}

}  // namespace pxpl5::host
