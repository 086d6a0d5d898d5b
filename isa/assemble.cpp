#include "isa/assemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <unordered_map>
#include <utility>

#include "isa/executor.hpp"

namespace pxpl5::isa {
namespace {

/// An expression's value lies in this range, so that sums and products of two fit 64 bits.
constexpr std::int64_t max_number = std::int64_t{1} << 31;

bool begins_name(char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool in_name(char c) {
    return begins_name(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// One line of text and a place in it. Reads what it is asked for, or fails with line and column.
class Line {
  public:
    Line(std::string_view text, std::size_t number) : text_(text), number_(number) {}

    [[noreturn]] void fail(std::size_t column, const std::string& what) const {
        throw AssemblyError(fmt::format("line {}, column {}: {}", number_, column + 1, what),
                            number_, column + 1);
    }

    /// Found and expected, at the next thing on the line.
    [[noreturn]] void fail_expecting(std::string_view expected) {
        skip_blanks();
        fail(at_, fmt::format("found {}, expected {}", found(), expected));
    }

    void skip_blanks() {
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) {
            ++at_;
        }
    }

    bool at_end() {
        skip_blanks();
        return at_ == text_.size();
    }

    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

    std::size_t column() const { return at_; }

    bool accept(std::string_view token) {
        if (text_.substr(at_, token.size()) != token) {
            return false;
        }
        at_ += token.size();
        return true;
    }

    void expect(std::string_view token) {
        if (!accept(token)) {
            fail_expecting(fmt::format("'{}'", token));
        }
    }

    std::string_view name(std::string_view expected) {
        skip_blanks();
        if (!begins_name(peek())) {
            fail_expecting(expected);
        }
        const std::size_t from = at_;
        while (in_name(peek())) {
            ++at_;
        }
        return text_.substr(from, at_ - from);
    }

    std::int64_t number() {
        const std::size_t from = at_;
        const bool hexadecimal = accept("0x");
        const std::int64_t base = hexadecimal ? 16 : 10;
        std::int64_t value = 0;
        std::size_t digits = 0;
        for (; digit(base) >= 0; ++at_, ++digits) {
            value = value * base + digit(base);
            if (value > std::int64_t{UINT32_MAX}) {
                fail(from, fmt::format("number is above {}", UINT32_MAX));
            }
        }
        if (digits == 0 || in_name(peek())) {
            at_ = from;
            fail_expecting("a number");
        }
        return value;
    }

  private:
    std::string found() const {
        if (at_ >= text_.size()) {
            return "the end of the line";
        }
        const std::size_t end = std::min(text_.find_first_of(" \t", at_), text_.size());
        return fmt::format("'{}'", text_.substr(at_, end - at_));
    }

    int digit(std::int64_t base) const {
        const char c = peek();
        const bool is_decimal = c >= '0' && c <= '9';
        const char lower = static_cast<char>(c | 0x20);
        const bool is_letter = base == 16 && lower >= 'a' && lower <= 'f';
        return is_decimal ? c - '0' : is_letter ? lower - 'a' + 10 : -1;
    }

    std::string_view text_;
    std::size_t number_;
    std::size_t at_ = 0;
};

std::unordered_map<std::string_view, std::size_t> rows_by_name() {
    std::unordered_map<std::string_view, std::size_t> rows;
    for (std::size_t i = 0; i < op_count; ++i) {
        rows.emplace(op_table[i].name, i);
    }
    return rows;
}

class Assembler {
  public:
    Program assemble(std::string_view text) {
        if (text.size() > max_assembly_bytes) {
            throw AssemblyError(fmt::format("line 1, column 1: {} bytes of text; the limit is {}",
                                            text.size(), max_assembly_bytes),
                                1, 1);
        }
        std::size_t number = 1;
        for (std::size_t from = 0; from <= text.size(); ++number) {
            const std::size_t end = std::min(text.find('\n', from), text.size());
            line(Line(without_comment(text.substr(from, end - from)), number));
            from = end + 1;
        }
        resolve();
        return std::move(program_);
    }

  private:
    /// A use of a label as coefficient, before all labels are known.
    struct LabelUse {
        std::string name;
        std::size_t word;
        Line line;
        std::size_t column;
    };

    static std::string_view without_comment(std::string_view text) {
        text = text.substr(0, text.find(';'));
        return text.ends_with('\r') ? text.substr(0, text.size() - 1) : text;
    }

    void line(Line line) {
        while (!line.at_end()) {
            if (line.accept(".def")) {
                return define(line);
            }
            const std::size_t column = line.column();
            const std::string_view name = line.name("an instruction, a label or .def");
            if (line.accept(":")) {
                label(line, column, name);
                continue;
            }
            const auto row = rows_.find(name);
            if (row == rows_.end()) {
                line.fail(column, fmt::format("found '{}', expected an instruction", name));
            }
            return instruction(line, row->second, column);
        }
    }

    void define(Line& line) {
        line.skip_blanks();
        const std::size_t column = line.column();
        const std::string name(line.name("a name"));
        const std::int64_t value = expression(line);
        if (!names_.emplace(name, value).second) {
            line.fail(column, fmt::format("'{}' is defined already, as {}", name, names_[name]));
        }
        expect_end(line);
    }

    void label(Line& line, std::size_t column, std::string_view name) {
        if (!program_.labels.emplace(name, program_.words.size()).second) {
            line.fail(column, fmt::format("label '{}' stands already at word {}", name,
                                          program_.labels.find(name)->second));
        }
    }

    void expect_end(Line& line) {
        if (!line.at_end()) {
            line.fail_expecting("the end of the line");
        }
    }

    // Expressions: sums and differences of products of numbers and names.

    std::int64_t expression(Line& line) {
        line.skip_blanks();
        const std::size_t column = line.column();
        const bool negative = line.accept("-");
        std::int64_t value = negative ? -term(line) : term(line);
        while (line.peek() == '+' || line.peek() == '-') {
            const bool minus = line.accept("-") || !line.accept("+");
            const std::int64_t other = term(line);
            value = in_range(line, column, minus ? value - other : value + other);
        }
        return value;
    }

    std::int64_t term(Line& line) {
        line.skip_blanks();
        const std::size_t column = line.column();
        std::int64_t value = factor(line);
        while (line.accept("*")) {
            // Both factors are at most 2^32, so that their product may overflow before the test.
            const std::int64_t other = factor(line);
            const bool fits = other == 0 || std::abs(value) <= 2 * max_number / std::abs(other);
            value = in_range(line, column, fits ? value * other : 4 * max_number);
        }
        return value;
    }

    static std::int64_t in_range(const Line& line, std::size_t column, std::int64_t value) {
        if (value < -max_number || value > 2 * max_number - 1) {
            line.fail(column, fmt::format("the value lies outside {}..{}", -max_number,
                                          2 * max_number - 1));
        }
        return value;
    }

    std::int64_t factor(Line& line) {
        line.skip_blanks();
        if (!begins_name(line.peek())) {
            return line.number();
        }
        const std::size_t column = line.column();
        const std::string_view name = line.name("a name");
        const auto found = names_.find(name);
        if (found == names_.end()) {
            line.fail(column, fmt::format("found '{}', expected a number or a name of .def", name));
        }
        return found->second;
    }

    // Instructions.

    void instruction(Line& line, std::size_t index, std::size_t column) {
        const OpInfo& row = op_table[index];
        Instruction in{static_cast<Op>(index), {}};
        const std::size_t word = program_.words.size();
        operands(line, row, in.operands, word);
        check_operands(line, row, in.operands, column);
        program_.words.push_back(encode(in));
        for (int i = 0; i < row.words; ++i) {
            coefficient(line, row, i);
        }
        expect_end(line);
    }

    /// Follows the row's text: what stands in braces is read, the rest must be there.
    void operands(Line& line, const OpInfo& row, Operands& o, std::size_t word) {
        for (std::size_t i = row.name.size(); i < row.text.size(); ++i) {
            const char c = row.text[i];
            if (c == ' ') {
                line.skip_blanks();
            } else if (c != '{') {
                line.expect(std::string_view(&c, 1));
            } else {
                const char which = row.text[i + 1];
                const bool is_address = row.text[i - 1] == 'm';
                const bool is_number = row.text[i - 1] == '#';
                std::uint32_t& target = which == 'a' ? o.a : which == 'b' ? o.b : o.n;
                target = is_number && line.accept("$") ? parameter(line, word, true)
                                                       : operand(line, row, which, is_address);
                i += 2;
            }
        }
    }

    /// An address is m8 or m[expression]; other operands are expressions as they stand.
    std::uint32_t operand(Line& line, const OpInfo& row, char which, bool is_address) {
        const std::size_t column = line.column();
        const bool bracket = is_address && line.accept("[");
        const std::int64_t value = is_address && !bracket ? line.number() : expression(line);
        if (bracket) {
            line.skip_blanks();
            line.expect("]");
        }
        if (value < 0 || value > UINT8_MAX) {
            line.fail(column, fmt::format("{}: operand {} is {}, expected 0..{}", row.name, which,
                                          value, UINT8_MAX));
        }
        return static_cast<std::uint32_t>(value);
    }

    void check_operands(Line& line, const OpInfo& row, const Operands& o, std::size_t column) {
        // The rules of check(), which finds all but what needs the whole program in one
        // instruction.
        std::vector<std::uint32_t> words(1 + static_cast<std::size_t>(row.words), 0);
        words[0] = encode({static_cast<Op>(&row - op_table.data()), o});
        if ((row.effects & (flow | backing)) == 0 || row.b_role == Role::block) {
            words.push_back(encode({Op::bs_wait, {}}));
            if (const CheckResult result = check(words); !result.ok()) {
                line.fail(column, result.error->text);
            }
        }
    }

    std::uint32_t parameter(Line& line, std::size_t word, bool is_operand) {
        const std::string name(line.name("a parameter's name"));
        program_.patches.push_back({name, word, is_operand});
        return 0;
    }

    void coefficient(Line& line, const OpInfo& row, int i) {
        if (line.at_end()) {
            line.fail_expecting(
                fmt::format("coefficient {} of {} of {}", i + 1, row.words, row.name));
        }
        const std::size_t word = program_.words.size();
        const std::size_t column = line.column();
        if (line.accept("$")) {
            program_.words.push_back(parameter(line, word, false));
        } else if (const std::string_view label = label_here(line, row); !label.empty()) {
            uses_.push_back({std::string(label), word, line, column});
            program_.words.push_back(0);
        } else {
            const std::int64_t value = expression(line);
            in_range(line, column, value);
            program_.words.push_back(static_cast<std::uint32_t>(value));
        }
    }

    /// The name at this place if it is to be a label: K of CALL or SKIPIFNONE, and no name of .def.
    std::string_view label_here(Line& line, const OpInfo& row) {
        if ((row.effects & flow) == 0 || !begins_name(line.peek())) {
            return {};
        }
        Line ahead = line;
        const std::string_view name = ahead.name("a label");
        if (names_.contains(name)) {
            return {};
        }
        line = ahead;
        return name;
    }

    void resolve() {
        for (const LabelUse& use : uses_) {
            const auto label = program_.labels.find(use.name);
            if (label == program_.labels.end()) {
                use.line.fail(
                    use.column,
                    fmt::format("found '{}', expected a label or a name of .def", use.name));
            }
            program_.words[use.word] = static_cast<std::uint32_t>(label->second);
        }
    }

    const std::unordered_map<std::string_view, std::size_t> rows_ = rows_by_name();
    std::map<std::string, std::int64_t, std::less<>> names_;
    std::vector<LabelUse> uses_;
    Program program_;
};

}  // namespace

Program assemble(std::string_view text) {
    return Assembler().assemble(text);
}

}  // namespace pxpl5::isa
