#include "host/base/answer.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/text_output.hpp"
#include "host/base/text_table.hpp"

namespace pxpl5::host {

namespace {

template <typename... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};

/// The cells of a row that programs read.
Fields fields_of(const Table& table, const std::vector<Cell>& row) {
    Fields fields;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
        if (!table.columns[i].key.empty()) {
            fields.push_back({table.columns[i].key, row[i].value});
        }
    }
    return fields;
}

std::vector<Fields> list_of(const Table& table) {
    std::vector<Fields> rows;
    for (const std::vector<Cell>& row : table.rows) {
        rows.push_back(fields_of(table, row));
    }
    return rows;
}

/// The cells of a row, or of the headings, that the text shows.
template <typename Row, typename Text>
TableRow shown(const Table& table, const Row& row, const Text& text) {
    TableRow cells;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
        if (!table.columns[i].heading.empty()) {
            cells.push_back(text(row[i]));
        }
    }
    return cells;
}

std::string text_of(const Table& table) {
    const TableRow heading =
        shown(table, table.columns, [](const Column& column) { return column.heading; });
    std::vector<TableRow> rows;
    for (const std::vector<Cell>& row : table.rows) {
        rows.push_back(shown(table, row, [](const Cell& cell) { return cell.text; }));
    }
    return heading.empty() ? "" : text_table(heading, rows, table.left);
}

}  // namespace

std::string Cell::plain_text(const FieldValue& value) {
    return std::visit(Overloaded{[](std::nullptr_t) { return std::string("-"); },
                                 [](bool yes) { return std::string(yes ? "yes" : "no"); },
                                 [](std::int64_t n) { return fmt::format("{}", n); },
                                 [](double number) { return fmt::format("{:g}", number); },
                                 [](const std::string& text) { return text; },
                                 [](const auto&) { return std::string(); }},
                      value);
}

Cell grouped_cell(std::uint64_t number) {
    return {field_value(number), grouped(number)};
}

Cell fixed_cell(double number, int digits) {
    return {number, fmt::format("{:.{}f}", number, digits)};
}

Cell hex_cell(std::uint64_t number) {
    return fmt::format("{:016x}", number);
}

std::string csv_heading(const Table& table) {
    std::string line;
    for (const Column& column : table.columns) {
        line += column.key.empty() ? "" : (line.empty() ? "" : ",") + column.key;
    }
    return line + "\n";
}

std::string csv_rows(const Table& table) {
    std::string text;
    for (const std::vector<Cell>& row : table.rows) {
        text += csv_line(fields_of(table, row));
    }
    return text;
}

Answer& Answer::line(std::string text) {
    items_.emplace_back(std::move(text) + "\n");
    return *this;
}

Answer& Answer::table(Table table) {
    items_.emplace_back(std::move(table));
    return *this;
}

Answer& Answer::sentences(std::string key, const std::string& word, const std::string& before,
                          const std::vector<std::string>& sentences) {
    std::vector<Answer> parts;
    for (const std::string& sentence : sentences) {
        parts.emplace_back().line(before + sentence).data(word, sentence);
    }
    return list(std::move(key), std::move(parts));
}

Answer& Answer::object(std::string key, Answer part) {
    items_.emplace_back(Parts{std::move(key), {std::move(part)}, false});
    return *this;
}

Answer& Answer::list(std::string key, std::vector<Answer> parts) {
    items_.emplace_back(Parts{std::move(key), std::move(parts), true});
    return *this;
}

Answer& Answer::append(Answer other) {
    std::ranges::move(other.items_, std::back_inserter(items_));
    return *this;
}

Answer& Answer::csv_table(Table table) {
    csv_ = {std::move(table)};
    return *this;
}

std::string Answer::text() const {
    std::string text;
    for (const auto& item : items_) {
        std::visit(Overloaded{[&](const std::string& line) { text += line; }, [](const Field&) {},
                              [&](const Table& table) { text += text_of(table); },
                              [&](const Parts& parts) {
                                  for (const Answer& answer : parts.answers) {
                                      text += answer.text();
                                  }
                              }},
                   item);
    }
    return text;
}

Fields Answer::fields() const {
    Fields fields;
    const auto add = [&](const std::string& key, FieldValue value) {
        if (!key.empty()) {
            fields.push_back({key, std::move(value)});
        }
    };
    for (const auto& item : items_) {
        std::visit(Overloaded{[](const std::string&) {},
                              [&](const Field& field) { fields.push_back(field); },
                              [&](const Table& table) { add(table.key, list_of(table)); },
                              [&](const Parts& parts) {
                                  std::vector<Fields> all;
                                  for (const Answer& answer : parts.answers) {
                                      all.push_back(answer.fields());
                                  }
                                  add(parts.key, parts.is_list ? FieldValue(std::move(all))
                                                               : FieldValue(all.front()));
                              }},
                   item);
    }
    return fields;
}

std::string Answer::csv() const {
    if (!csv_.empty()) {
        return csv_heading(csv_.front()) + csv_rows(csv_.front());
    }
    for (const auto& item : items_) {
        if (const auto* table = std::get_if<Table>(&item)) {
            return csv_heading(*table) + csv_rows(*table);
        }
    }
    return {};
}

Reply Answer::reply() const {
    Reply reply{text(), fields()};
    if (reply.text.ends_with('\n')) {
        reply.text.pop_back();
    }
    return reply;
}

std::string rendered(const Answer& answer, Format format) {
    switch (format) {
        case Format::json:
            return json_text(answer.fields()) + "\n";
        case Format::csv:
            return answer.csv();
        case Format::text:
            break;
    }
    return answer.text();
}

void write(const Answer& answer, Format format, const std::string& path) {
    TextOutput output(path);
    output.put(rendered(answer, format));
    output.finish();
}

}  // namespace pxpl5::host
