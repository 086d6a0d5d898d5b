// The answer of a tool, stated once and rendered as text, as JSON or as CSV.
#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "host/base/chart_axis.hpp"
#include "host/base/reply.hpp"

namespace pxpl5::host {

/// Converts numbers, texts and fields to the value of a field. An empty optional is null.
template <typename T>
FieldValue field_value(const T& value) {
    if constexpr (std::same_as<T, bool> || std::same_as<T, std::nullptr_t>) {
        return value;
    } else if constexpr (std::integral<T>) {
        return static_cast<std::int64_t>(value);
    } else if constexpr (std::floating_point<T>) {
        return double{value};
    } else if constexpr (std::convertible_to<const T&, std::string_view>) {
        return std::string(std::string_view(value));
    } else if constexpr (requires { value.has_value(); }) {
        return value ? field_value(*value) : FieldValue(nullptr);
    } else if constexpr (requires { value[0] + 0.0; }) {
        return std::vector<double>(std::begin(value), std::end(value));
    } else {
        return value;
    }
}

/// 1234567 as "1,234,567".
template <std::integral T>
std::string grouped(T number) {
    return grouped(static_cast<double>(number));
}

/// A value of a table, and how the text shows the value.
struct Cell {
    FieldValue value;
    std::string text;

    Cell(FieldValue its_value, std::string its_text)
        : value(std::move(its_value)), text(std::move(its_text)) {}
    /// The text is the value itself; "-" for null.
    template <typename T>
    Cell(const T& of) : value(field_value(of)), text(plain_text(value)) {}

  private:
    static std::string plain_text(const FieldValue& value);
};
/// Cells that the text shows as "1,234", as "0.125" and as "00000000000000ff".
Cell grouped_cell(std::uint64_t number);
Cell fixed_cell(double number, int digits);
Cell hex_cell(std::uint64_t number);

struct Column {
    std::string key;      ///< JSON and CSV; empty: the column is only in the text.
    std::string heading;  ///< Text; empty: the column is only in JSON and CSV.
};

/// Every row has one cell per column. A null cell is "-" in the text and empty in CSV.
struct Table {
    std::string key;  ///< Name of the list in JSON; empty: the table is not in JSON.
    std::vector<Column> columns;
    std::vector<std::vector<Cell>> rows{};
    std::size_t left = 1;  ///< Leading columns of the text that are aligned at the left.
};

/// The heading and the rows of a table as CSV, each line with its end.
std::string csv_heading(const Table& table);
std::string csv_rows(const Table& table);

class Answer {
  public:
    /// A line of the text. The end of the line is added.
    Answer& line(std::string text);
    /// A field of the JSON object.
    template <typename T>
    Answer& data(std::string key, const T& value) {
        items_.emplace_back(Field{std::move(key), field_value(value)});
        return *this;
    }
    /// A field of the JSON object, unless the value is empty.
    template <typename T>
    Answer& data_if(std::string key, const std::optional<T>& value) {
        return value ? data(std::move(key), *value) : *this;
    }
    Answer& data_if(std::string key, const std::string& value) {
        return value.empty() ? *this : data(std::move(key), value);
    }
    /// A table of the text, and a list of objects in JSON.
    Answer& table(Table table);
    /// A list of {"`word`": sentence} in JSON; a line "`before`sentence" for each in the text.
    Answer& sentences(std::string key, const std::string& word, const std::string& before,
                      const std::vector<std::string>& sentences);
    /// An answer inside this answer: an object in JSON, or an element of a list of objects.
    Answer& object(std::string key, Answer part);
    Answer& list(std::string key, std::vector<Answer> parts);
    /// Adds the items of another answer to this answer.
    Answer& append(Answer other);
    /// The table that CSV shows instead of the first table.
    Answer& csv_table(Table table);

    std::string text() const;
    Fields fields() const;
    std::string csv() const;
    /// Text without the end of the last line, and fields.
    Reply reply() const;

  private:
    struct Parts {
        std::string key;
        std::vector<Answer> answers;
        bool is_list;
    };
    std::vector<std::variant<std::string, Field, Table, Parts>> items_;
    std::vector<Table> csv_;
};

enum class Format : std::uint8_t { text, json, csv };
/// The answer in a format, as a file holds it.
std::string rendered(const Answer& answer, Format format);
/// Writes the answer to a file, or to standard output. Throws as TextOutput.
void write(const Answer& answer, Format format, const std::string& path);

}  // namespace pxpl5::host
