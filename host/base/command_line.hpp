// One command line, taken apart: words, and key=value options.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pxpl5::host {

/// Throws RequestError (usage).
[[noreturn]] void refuse_command(const std::string& text);

/// A command's words after its name, and its options.
struct Arguments {
    std::string name;                            ///< First word.
    std::vector<std::string> words;              ///< The others that are not options.
    std::map<std::string, std::string> options;  ///< key=value; each key at most once.

    bool has(std::string_view key) const { return options.count(std::string(key)) != 0; }
    /// The option's text, or `otherwise`.
    std::string text(std::string_view key, std::string_view otherwise) const;
    /// The option as a number, or `otherwise` if absent; check_arguments() has checked its range.
    double number(std::string_view key, double otherwise) const;
};

/// Whether the text, which begins with a word, begins with a comment: '#' and a blank or the end.
inline bool begins_comment(std::string_view text) {
    return text.starts_with('#') && (text.size() == 1 || std::string_view(" \t\r\n").find(
                                                             text[1]) != std::string_view::npos);
}

/// Splits at blanks; quotes ('..' or "..") keep blanks and '='; '#' at the start of a word begins a
/// comment. Returns an empty name for a blank line. Throws RequestError (usage) for an open quote,
/// a repeated key or a NUL byte.
Arguments parse_line(std::string_view line);

/// A line that parse_line() takes apart into `arguments` again, whatever text is in them.
std::string to_line(const Arguments& arguments);

/// The whole of `text` as a number in [low, high]. Throws RequestError naming `what` and both.
double parse_number(std::string_view what, std::string_view text,
                    double low = std::numeric_limits<double>::lowest(),
                    double high = std::numeric_limits<double>::max());

/// The whole of `text` as a whole number in [low, high]. Throws RequestError naming `what` and
/// both.
int parse_whole(std::string_view what, std::string_view text,
                int low = std::numeric_limits<int>::min(),
                int high = std::numeric_limits<int>::max());

/// "1,2,3" or "1x2x3" as three numbers, each in [low, high]. Throws RequestError.
glm::dvec3 parse_triple(std::string_view what, std::string_view text, double low, double high);

/// "120,80" as two whole numbers. Throws RequestError.
std::pair<int, int> parse_pair(std::string_view what, std::string_view text);

/// "640x480" as two whole numbers, each in [low, high]. Throws RequestError.
struct Size {
    int width = 0, height = 0;
    friend bool operator==(const Size&, const Size&) = default;
};
Size parse_size(std::string_view text, int low, int high);

struct Color {
    std::uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Color&, const Color&) = default;
};

/// "#rrggbb", "r,g,b" (0..255) or a name (white, bone, skin, red, ...). Throws RequestError.
Color parse_color(std::string_view text);

}  // namespace pxpl5::host
