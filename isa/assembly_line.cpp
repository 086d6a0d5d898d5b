#include "isa/assembly_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "isa/assemble.hpp"

namespace pxpl5::isa {
namespace {

bool begins_name(char c) {
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}
bool in_name(char c) {
    return begins_name(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
}

}  // namespace

void AssemblyLine::fail(std::size_t column, const std::string& what) const {
    throw AssemblyError(fmt::format("line {}, column {}: {}", number_, column + 1, what), number_,
                        column + 1);
}

void AssemblyLine::fail_expecting(std::string_view expected) {
    skip_blanks();
    fail(at_, fmt::format("found {}, expected {}{}", found(), expected,
                          row_ == nullptr ? "" : ". Syntax: " + syntax_of(*row_)));
}

void AssemblyLine::skip_blanks() {
    at_ = std::min(text_.find_first_not_of(" \t", at_), text_.size());
}

bool AssemblyLine::at_end() {
    skip_blanks();
    return at_ == text_.size();
}

bool AssemblyLine::accept(std::string_view token) {
    if (text_.substr(at_, token.size()) != token) {
        return false;
    }
    at_ += token.size();
    return true;
}

void AssemblyLine::expect(std::string_view token) {
    if (!accept(token)) {
        fail_expecting(fmt::format("'{}'", token));
    }
}

std::string_view AssemblyLine::name(std::string_view expected) {
    skip_blanks();
    if (!at_name()) {
        fail_expecting(expected);
    }
    const std::size_t from = at_;
    while (in_name(peek())) {
        ++at_;
    }
    return text_.substr(from, at_ - from);
}

bool AssemblyLine::at_name() const {
    return begins_name(peek());
}

std::int64_t AssemblyLine::number() {
    const std::size_t from = at_;
    const std::int64_t base = accept("0x") ? 16 : 10;
    std::int64_t value = 0;
    std::size_t digits = 0;
    for (; digit(base) >= 0; ++at_, ++digits) {
        value = value * base + digit(base);
        if (value > std::int64_t{UINT32_MAX}) {
            fail(from, fmt::format("the number is above {}", UINT32_MAX));
        }
    }
    if (digits == 0 || in_name(peek())) {
        at_ = from;
        fail_expecting("a number");
    }
    return value;
}

std::string AssemblyLine::found() const {
    if (at_ >= text_.size()) {
        return "the end of the line";
    }
    const std::size_t end = std::min(text_.find_first_of(" \t", at_), text_.size());
    return fmt::format("'{}'", text_.substr(at_, end - at_));
}

int AssemblyLine::digit(std::int64_t base) const {
    const char c = peek();
    const bool is_decimal = c >= '0' && c <= '9';
    const char lower = static_cast<char>(c | 0x20);
    const bool is_letter = base == 16 && lower >= 'a' && lower <= 'f';
    return is_decimal ? c - '0' : is_letter ? lower - 'a' + 10 : -1;
}

}  // namespace pxpl5::isa
