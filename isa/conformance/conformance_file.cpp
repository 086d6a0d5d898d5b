#include "isa/conformance/conformance_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "isa/assemble.hpp"
#include "isa/executor.hpp"

namespace pxpl5::isa {
namespace {

constexpr std::uint64_t max_coefficient = INT32_MAX;
constexpr std::uint64_t min_coefficient = static_cast<std::uint64_t>(std::int64_t{INT32_MIN});
constexpr std::array<int, 6> degrees = {1, 1, 0,
                                        2, 2, 2};  ///< Degrees of the terms of a Quadratic.

/// A word of the text and its position, from 1.
struct Token {
    std::string_view text;
    std::size_t line = 0, column = 0;

    [[noreturn]] void fail(std::size_t at, const std::string& what) const {
        throw ConformanceError(fmt::format("line {}, column {}: {}", line, column + at, what), line,
                               column + at);
    }
    [[noreturn]] void fail_expecting(std::string_view expected) const {
        fail(0, fmt::format("found '{}', expected {}", text, expected));
    }
};

/// Reads one token from left to right.
class Reader {
  public:
    explicit Reader(const Token& token) : token_(token) {}

    bool at_end() const { return at_ == token_.text.size(); }
    char peek() const { return at_end() ? '\0' : token_.text[at_]; }
    bool accept(std::string_view part) {
        const bool here = token_.text.substr(at_).starts_with(part);
        at_ += here ? part.size() : 0;
        return here;
    }
    [[noreturn]] void fail_expecting(std::string_view expected) const {
        const std::string_view rest = token_.text.substr(at_);
        token_.fail(at_, rest.empty() ? fmt::format("'{}' ends, expected {}", token_.text, expected)
                                      : fmt::format("found '{}', expected {}", rest, expected));
    }
    void expect(std::string_view part) {
        if (!accept(part)) {
            fail_expecting(fmt::format("'{}'", part));
        }
    }
    void expect_end() const {
        if (!at_end()) {
            fail_expecting("a blank");
        }
    }

    std::uint64_t number(std::uint64_t limit = UINT64_MAX) {
        const std::size_t from = at_;
        const int base = accept("0x") ? 16 : 10;
        const char* const begin = token_.text.data() + at_;
        std::uint64_t value = 0;
        const auto [end, error] =
            std::from_chars(begin, token_.text.data() + token_.text.size(), value, base);
        if (error == std::errc::invalid_argument) {
            at_ = from;
            fail_expecting("a number");
        }
        if (error == std::errc::result_out_of_range || value > limit) {
            token_.fail(from, fmt::format("the number is above {}", limit));
        }
        at_ += static_cast<std::size_t>(end - begin);
        return value;
    }

    /// Reads sums and differences of products of numbers, x and y, of degree 2 at most.
    Quadratic quadratic() {
        Quadratic sum;
        bool minus = accept("-");
        do {
            const Quadratic one = product();
            for (std::size_t i = 0; i < sum.k.size(); ++i) {
                sum.k[i] += minus ? 0 - one.k[i] : one.k[i];
            }
            minus = peek() == '-';
        } while (accept("+") || accept("-"));
        return sum;
    }

  private:
    Quadratic product() {
        Quadratic value = factor();
        while (accept("*")) {
            const std::size_t from = at_;
            value = multiplied(value, factor(), from);
        }
        return value;
    }

    Quadratic factor() {
        Quadratic value;
        if (accept("x")) {
            value.k[0] = 1;
        } else if (accept("y")) {
            value.k[1] = 1;
        } else {
            value.k[2] = number();
        }
        return value;
    }

    /// Multiplies two factors that have one term each.
    Quadratic multiplied(const Quadratic& p, const Quadratic& q, std::size_t from) const {
        const auto term = [](const Quadratic& value) {
            const auto found = std::ranges::find_if(value.k, [](auto k) { return k != 0; });
            return found == value.k.end() ? std::size_t{2}
                                          : static_cast<std::size_t>(found - value.k.begin());
        };
        const std::size_t i = term(p), j = term(q);
        if (degrees[i] + degrees[j] > 2) {
            token_.fail(from, "the degree of the product in x and y is above 2");
        }
        Quadratic value;
        // x x is term 3, x y term 4, y y term 5; term 2 is the constant.
        const std::size_t k = degrees[i] == 0 ? j : degrees[j] == 0 ? i : 3 + i + j;
        value.k[k] = p.k[i] * q.k[j];
        return value;
    }

    const Token& token_;
    std::size_t at_ = 0;
};

/// Reads a..b, one number, or * for 0..127.
std::pair<int, int> range(Reader& reader) {
    constexpr std::uint64_t last = region_px - 1;
    if (reader.accept("*")) {
        return {0, region_px - 1};
    }
    const auto from = static_cast<int>(reader.number(last));
    const int to = reader.accept("..") ? static_cast<int>(reader.number(last)) : from;
    return {from, to};
}

PixelRectangle rectangle(const Token& token) {
    Reader reader(token);
    const auto [x0, x1] = range(reader);
    reader.expect(",");
    const auto [y0, y1] = range(reader);
    reader.expect_end();
    if (x0 > x1 || y0 > y1) {
        token.fail(0, fmt::format("'{}' contains no pixel", token.text));
    }
    return {x0, y0, x1, y1};
}

PixelSelector selector(const Token& token) {
    if (token.text == "all") {
        return {};
    }
    const std::size_t relation = token.text.find(">=");
    if (relation == std::string_view::npos) {
        return {rectangle(token), std::nullopt};
    }
    Reader reader(token);
    const Quadratic value = reader.quadratic();
    reader.expect(">=0");
    reader.expect_end();
    if (!value.fits_coefficient_words()) {
        token.fail(0, "a coefficient does not fit a signed 32-bit number");
    }
    return {{}, value};
}

StateColumn column(const Token& token, bool is_given) {
    using Kind = StateColumn::Kind;
    constexpr std::string_view names = "m0:8, enable, carry, bs0 or readout";
    if (token.text == "enable" || token.text == "carry") {
        return {token.text == "enable" ? Kind::enable : Kind::carry, 0, 1};
    }
    if (token.text == "readout") {
        if (is_given) {
            token.fail(0, "readout is a column of 'expect', not of 'given'");
        }
        return {Kind::readout, 0, 32};
    }
    Reader reader(token);
    if (reader.accept("bs")) {
        const auto block = static_cast<std::uint32_t>(reader.number(backing_blocks - 1));
        reader.expect_end();
        return {Kind::block, block, backing_block_bits};
    }
    if (!reader.accept("m")) {
        token.fail_expecting(names);
    }
    const auto a = static_cast<std::uint32_t>(reader.number(memory_bits - 1));
    reader.expect(":");
    const auto n = static_cast<std::uint32_t>(reader.number(64));
    reader.expect_end();
    if (n == 0 || a + n > memory_bits) {
        token.fail(0, fmt::format("field '{}' must have 1..64 bits within the {} bits of a pixel",
                                  token.text, memory_bits));
    }
    return {Kind::field, a, n};
}

class Parser {
  public:
    ConformanceCase parse(std::string_view text) {
        std::size_t number = 1;
        for (std::size_t from = 0; from <= text.size(); ++number) {
            const std::size_t end = std::min(text.find('\n', from), text.size());
            line(text.substr(from, end - from), number);
            from = end + 1;
        }
        finish();
        return std::move(case_);
    }

  private:
    using Tokens = std::vector<Token>;

    static Tokens tokens_of(std::string_view line, std::size_t number) {
        line = line.substr(0, line.find(';'));
        Tokens tokens;
        for (std::size_t at = 0; (at = line.find_first_not_of(" \t\r", at)) < line.size();) {
            const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
            tokens.push_back({line.substr(at, end - at), number, at + 1});
            at = end;
        }
        return tokens;
    }

    void line(std::string_view text, std::size_t number) {
        const Tokens tokens = tokens_of(text, number);
        const bool opens = !tokens.empty() && tokens.front().column == 1;
        if (opens) {
            open(tokens, text);
        } else if (!tokens.empty()) {
            inside(tokens);
        }
        // The assembler receives empty lines for all other sections, so that its errors name the
        // lines of the file.
        assembly_ += section_ == "run" && !opens ? text : "";
        assembly_ += '\n';
    }

    void open(const Tokens& tokens, std::string_view text) {
        const Token& first = tokens.front();
        section_ = first.text;
        if (section_ == "title") {
            text = text.substr(section_.size(), text.find(';') - section_.size());
            const std::size_t from = std::min(text.find_first_not_of(" \t"), text.size());
            case_.title = text.substr(from, text.find_last_not_of(" \t\r") + 1 - from);
        } else if (section_ == "given" || section_ == "expect") {
            table(tokens);
        } else if (section_ == "run") {
            if (run_.line != 0) {
                first.fail(0, fmt::format("the case already has 'run' in line {}", run_.line));
            }
            run_ = first;
            expect_count(tokens, 1);
        } else {
            fact(tokens);
        }
    }

    /// Reads sections of one line.
    void fact(const Tokens& tokens) {
        const Token& first = tokens.front();
        const auto number = [&](std::size_t i, std::uint64_t limit) {
            Reader reader(tokens[i]);
            const std::uint64_t value = reader.number(limit);
            reader.expect_end();
            return value;
        };
        if (section_ == "watch") {
            for (std::size_t i = 1; i < tokens.size(); ++i) {
                case_.watch.push_back(rectangle(tokens[i]));
            }
        } else if (section_ == "signals") {
            for (std::size_t i = 1; i < tokens.size(); ++i) {
                case_.signals.push_back(static_cast<std::uint32_t>(number(i, UINT8_MAX)));
            }
        } else if (section_ == "flag") {
            expect_count(tokens, 2);
            case_.flag = number(1, 1) != 0;
        } else if (section_ == "instructions" || section_ == "cycles") {
            expect_count(tokens, 2);
            (section_ == "cycles" ? case_.cycles : case_.instructions) = number(1, UINT64_MAX);
        } else if (section_ == "stops") {
            for (std::size_t i = 1; i < tokens.size(); ++i) {
                case_.stops += (i == 1 ? "" : " ") + std::string(tokens[i].text);
            }
        } else {
            first.fail_expecting(
                "title, watch, given, run, expect, signals, flag, instructions, "
                "cycles, stops, or a blank before what belongs to one");
        }
    }

    static void expect_count(const Tokens& tokens, std::size_t count) {
        if (tokens.size() > count) {
            tokens[count].fail_expecting("the end of the line");
        }
        if (tokens.size() < count) {
            tokens.back().fail(tokens.back().text.size(), "the line ends, expected a value");
        }
    }

    void table(const Tokens& tokens) {
        StateTable& table = tables().emplace_back();
        for (std::size_t i = 1; i < tokens.size(); ++i) {
            table.columns.push_back(column(tokens[i], section_ == "given"));
        }
    }

    std::vector<StateTable>& tables() { return section_ == "given" ? case_.given : case_.expect; }

    void inside(const Tokens& tokens) {
        if (section_ == "given" || section_ == "expect") {
            row(tokens);
        } else if (section_ != "run") {
            tokens.front().fail_expecting("a section's name, without a blank before it");
        }
    }

    void row(const Tokens& tokens) {
        StateTable& table = tables().back();
        StateTable::Row row{selector(tokens.front()), {}};
        expect_count(tokens, 1 + table.columns.size());
        for (std::size_t i = 1; i < tokens.size(); ++i) {
            row.values.push_back(value(tokens[i]));
        }
        table.rows.push_back(std::move(row));
    }

    std::optional<Quadratic> value(const Token& token) const {
        if (token.text == "-") {
            return std::nullopt;
        }
        Reader reader(token);
        const Quadratic value = reader.quadratic();
        reader.expect_end();
        if (section_ == "given" && !value.is_constant() && !value.fits_coefficient_words()) {
            token.fail(0, "a coefficient does not fit a signed 32-bit number");
        }
        return value;
    }

    void finish() {
        if (run_.line == 0) {
            throw ConformanceError("line 1, column 1: the case has no section 'run'", 1, 1);
        }
        try {
            case_.program = assemble(assembly_);
        } catch (const AssemblyError& error) {
            throw ConformanceError(error.what(), error.line, error.column);
        }
        if (!case_.program.patches.empty()) {
            run_.fail(
                0, fmt::format("parameter ${} has no value", case_.program.patches.front().name));
        }
        if (const CheckResult result = check(case_.program.words); !result.ok()) {
            run_.fail(0, fmt::format("word {} of the program: {}", result.error->word,
                                     result.error->text));
        }
    }

    ConformanceCase case_;
    std::string_view section_;
    std::string assembly_;
    Token run_;
};

}  // namespace

bool Quadratic::fits_coefficient_words() const {
    return std::ranges::all_of(
        k, [](std::uint64_t v) { return v <= max_coefficient || v >= min_coefficient; });
}

ConformanceCase parse_conformance(std::string_view text) {
    return Parser().parse(text);
}

}  // namespace pxpl5::isa
