#include "isa/assemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <ranges>
#include <unordered_map>
#include <utility>

#include "isa/assembly_line.hpp"
#include "isa/nearest.hpp"

namespace pxpl5::isa {
namespace {

/// Limits the value of an expression, so that the sum of two values fits 64 bits.
constexpr std::int64_t max_number = std::int64_t{1} << 31;

/// Text with a NUL byte is most likely a binary file of words.
void refuse_binary(std::string_view text) {
    const std::size_t nul = text.find('\0');
    if (nul == std::string_view::npos) {
        return;
    }
    const auto line = static_cast<std::size_t>(1 + std::ranges::count(text.substr(0, nul), '\n'));
    const std::size_t column = nul - (text.substr(0, nul).rfind('\n') + 1) + 1;
    throw AssemblyError(fmt::format("line {}, column {}: found a NUL byte, expected assembly text. "
                                    "If the input holds binary instruction words, `pxpl5 dis` "
                                    "prints them as assembly",
                                    line, column),
                        line, column);
}

/// ". Did you mean 'NOP'?" if a known name is close to `word`, else empty.
template <typename Names>
std::string suggestion(std::string_view word, const Names& names) {
    const std::vector<std::string_view> known(names.begin(), names.end());
    const std::string_view near = nearest(word, known);
    return near.empty() ? "" : fmt::format(". Did you mean '{}'?", near);
}

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
            throw AssemblyError(fmt::format("line 1, column 1: the text has {} bytes; the limit is "
                                            "{} bytes",
                                            text.size(), max_assembly_bytes),
                                1, 1);
        }
        refuse_binary(text);
        std::size_t number = 1;
        for (std::size_t from = 0; from <= text.size(); ++number) {
            const std::size_t end = std::min(text.find('\n', from), text.size());
            line(AssemblyLine(without_comment(text.substr(from, end - from)), number));
            from = end + 1;
        }
        resolve();
        return std::move(program_);
    }

  private:
    /// A label as coefficient. resolve() replaces it when all labels are known.
    struct LabelUse {
        std::string name;
        std::size_t word;
        AssemblyLine line;
        std::size_t column;
    };

    static std::string_view without_comment(std::string_view text) {
        text = text.substr(0, text.find(';'));
        return text.ends_with('\r') ? text.substr(0, text.size() - 1) : text;
    }

    void line(AssemblyLine line) {
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
                line.fail(
                    column,
                    fmt::format("found '{}', expected an instruction{}", name,
                                suggestion(name, std::views::transform(op_table, &OpInfo::name))));
            }
            return instruction(line, row->second, column);
        }
    }

    void define(AssemblyLine& line) {
        line.skip_blanks();
        const std::size_t column = line.column();
        const std::string name(line.name("a name"));
        const std::int64_t value = expression(line);
        if (!names_.emplace(name, value).second) {
            line.fail(column, fmt::format("'{}' is already defined as {}", name, names_[name]));
        }
        expect_end(line);
    }

    void label(AssemblyLine& line, std::size_t column, std::string_view name) {
        if (!program_.labels.emplace(name, program_.words.size()).second) {
            line.fail(column, fmt::format("label '{}' is already defined at word {}", name,
                                          program_.labels.find(name)->second));
        }
    }

    void expect_end(AssemblyLine& line) {
        if (!line.at_end()) {
            line.fail_expecting("the end of the line");
        }
    }

    // Expressions: sums and differences of products of numbers and names.

    std::int64_t expression(AssemblyLine& line) {
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

    std::int64_t term(AssemblyLine& line) {
        line.skip_blanks();
        const std::size_t column = line.column();
        std::int64_t value = factor(line);
        while (line.accept("*")) {
            // Both factors are at most 2^32, so their product may overflow: test before
            // multiplying.
            const std::int64_t other = factor(line);
            const bool fits = other == 0 || std::abs(value) <= 2 * max_number / std::abs(other);
            value = in_range(line, column, fits ? value * other : 4 * max_number);
        }
        return value;
    }

    static std::int64_t in_range(const AssemblyLine& line, std::size_t column, std::int64_t value) {
        if (value < -max_number || value > 2 * max_number - 1) {
            line.fail(column,
                      fmt::format("the value is outside {}..{}", -max_number, 2 * max_number - 1));
        }
        return value;
    }

    std::int64_t factor(AssemblyLine& line) {
        line.skip_blanks();
        if (!line.at_name()) {
            return line.number();
        }
        const std::size_t column = line.column();
        const std::string_view name = line.name("a name");
        const auto found = names_.find(name);
        if (found == names_.end()) {
            line.fail(column, fmt::format("found '{}', expected a number or a name of .def{}", name,
                                          suggestion(name, std::views::keys(names_))));
        }
        return found->second;
    }

    // Instructions.

    void instruction(AssemblyLine& line, std::size_t index, std::size_t column) {
        const OpInfo& row = op_table[index];
        Instruction in{static_cast<Op>(index), {}};
        const std::size_t word = program_.words.size();
        line.set_instruction(row);
        operands(line, row, in.operands, word);
        check_operands(line, row, in.operands, column);
        program_.words.push_back(encode(in));
        for (int i = 0; i < row.words; ++i) {
            coefficient(line, row, i);
        }
        expect_end(line);
    }

    /// Follows the row's text: reads an operand for each {x}, and requires all other characters.
    void operands(AssemblyLine& line, const OpInfo& row, Operands& o, std::size_t word) {
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

    /// An address is m8 or m[expression]; any other operand is an expression.
    std::uint32_t operand(AssemblyLine& line, const OpInfo& row, char which, bool is_address) {
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

    void check_operands(AssemblyLine& line, const OpInfo& row, const Operands& o,
                        std::size_t column) {
        // check() applies all rules that concern one instruction alone.
        std::vector<std::uint32_t> words(1 + static_cast<std::size_t>(row.words), 0);
        words[0] = encode({static_cast<Op>(&row - op_table.data()), o});
        if ((row.effects & (flow | backing)) == 0 || row.b_role == Role::block) {
            words.push_back(encode({Op::bs_wait, {}}));
            if (const CheckResult result = check(words); !result.ok()) {
                line.fail(column, result.error->text);
            }
        }
    }

    std::uint32_t parameter(AssemblyLine& line, std::size_t word, bool is_operand) {
        const std::string name(line.name("a parameter's name"));
        program_.patches.push_back({name, word, is_operand});
        return 0;
    }

    void coefficient(AssemblyLine& line, const OpInfo& row, int i) {
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

    /// Reads a label: a name as K of CALL or SKIPIFNONE that .def has not defined. Returns an empty
    /// text, and reads nothing, if there is no label.
    std::string_view label_here(AssemblyLine& line, const OpInfo& row) {
        if ((row.effects & flow) == 0 || !line.at_name()) {
            return {};
        }
        AssemblyLine ahead = line;
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
                    fmt::format("found '{}', expected a label or a name of .def{}", use.name,
                                suggestion(use.name, std::views::keys(program_.labels))));
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

std::string syntax_of(const OpInfo& row) {
    std::string text;
    std::ranges::copy_if(row.text, std::back_inserter(text),
                         [](char c) { return c != '{' && c != '}'; });
    constexpr std::string_view coefficients[] = {"", " K", {}, " A B C", {}, {}, " A B C D E F"};
    return text.append(coefficients[row.words]);
}

Program assemble(std::string_view text) {
    return Assembler().assemble(text);
}

}  // namespace pxpl5::isa
