// What a command answers: a text for people and fields for programs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace pxpl5::host {

struct Field;
using Fields = std::vector<Field>;
using FieldValue = std::variant<std::nullptr_t, bool, std::int64_t, double, std::string,
                                std::vector<double>, Fields, std::vector<Fields>>;

struct Field {
    std::string name;
    FieldValue value;
};

struct Reply {
    std::string text;  ///< May be empty; no newline at the end.
    Fields fields;
};

/// As a JSON object on one line.
std::string json_text(const Fields& fields);

/// A line of a CSV table, and the one above the first: texts in quotes, quotes doubled; null is
/// empty. Both end with a newline. No field holds a list.
std::string csv_heading(const Fields& fields);
std::string csv_line(const Fields& fields);

/// The outcome of one command line as one JSON object on one line:
/// {"command", "ok", "result" or "error", "ms"}.
std::string json_line(const std::string& command, const Reply& reply, double elapsed_ms);
std::string json_error_line(const std::string& command, const std::string& error, int exit_code,
                            double elapsed_ms);

}  // namespace pxpl5::host
