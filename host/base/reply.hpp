// The answer of a command: text for people, fields for programs, and warnings for both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace pxpl5::host {

struct Field;
using Fields = std::vector<Field>;
using FieldValue =
    std::variant<std::nullptr_t, bool, std::int64_t, double, std::string, std::vector<double>,
                 std::vector<std::int64_t>, std::vector<std::string>, Fields, std::vector<Fields>>;

struct Field {
    std::string name;
    FieldValue value;
};

struct Reply {
    std::string text;  ///< May be empty; no newline at the end.
    Fields fields;
    std::vector<std::string> warnings = {};  ///< The text has them, too.
};

/// Adds a warning to the text, behind `separator`, and to the list.
void add_warning(Reply& reply, const std::string& warning, std::string_view separator = "\n");

/// Version of the JSON lines below; see host/commands/JSON.md.
inline constexpr std::int64_t json_schema = 1;

/// The fields as a JSON object on one line.
std::string json_text(const Fields& fields);

/// A line of a CSV table, and the one above the first: texts in quotes, quotes doubled; null is
/// empty. Both end with a newline. No field holds a list.
std::string csv_heading(const Fields& fields);
std::string csv_line(const Fields& fields);

/// A command line that was run.
struct CommandOutcome {
    std::string command;  ///< The line without blanks at its ends.
    std::string name;     ///< The command; empty if the line has no valid first word.
    double elapsed_ms = 0;
    std::vector<Fields> restarts = {};  ///< Restarts of the machine before the answer.
};

/// The outcome of one command line as one JSON object on one line:
/// {"schema", "command", "name", "ok", "result", "warnings", "restarts", "ms"}. Without restarts,
/// "restarts" is left out.
std::string json_line(const CommandOutcome& outcome, const Reply& reply);
/// The same with "error" and "exit_code". `reply` is what was done before the error, if anything.
std::string json_error_line(const CommandOutcome& outcome, const std::string& error, int exit_code,
                            const Reply* reply = nullptr);

}  // namespace pxpl5::host
