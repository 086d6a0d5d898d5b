#include "host/phigs/lexer.hpp"

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <optional>

#include "host/base/error.hpp"

namespace pxpl5::host::phigs {

namespace {

constexpr std::size_t max_shown = 40;  ///< Letters of a word in a message.

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v';
}

bool is_punctuation(char c) {
    return c == '{' || c == '}' || c == ';';
}

/// Returns the text with unprintable bytes in hexadecimal.
std::string shown(std::string_view word) {
    std::string text;
    for (const char c : word.substr(0, max_shown)) {
        const bool plain = c >= ' ' && c <= '~';
        text +=
            plain ? std::string(1, c) : fmt::format("\\x{:02x}", static_cast<unsigned>(c) & 0xFFU);
    }
    return "'" + text + (word.size() > max_shown ? "...'" : "'");
}

std::optional<double> as_number(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') {
        word.remove_prefix(1);  // from_chars knows no plus.
    }
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error == std::errc::result_out_of_range && end == word.data() + word.size()) {
        return word.find("e-") != word.npos || word.find("E-") != word.npos ? 0.0 : HUGE_VAL;
    }
    if (error != std::errc{} || end != word.data() + word.size() || std::isnan(value)) {
        return std::nullopt;
    }
    return value;
}

}  // namespace

void refuse_text(const std::string& file, Place at, const std::string& text) {
    throw RequestError(ExitCode::bad_data,
                       fmt::format("{}:{}:{}: {}", file, at.line, at.column, text));
}

void Lexer::refuse_at(Place at, const std::string& text) const {
    refuse_text(file_, at, text);
}

void Lexer::unexpected(std::string_view expected) const {
    refuse_at(token_.at,
              fmt::format("found {}, expected {}",
                          at_end() ? "the end of the file" : shown(token_.text), expected));
}

void Lexer::step() {
    if (text_[at_++] == '\n') {
        ++place_.line;
        place_.column = 1;
    } else {
        ++place_.column;
    }
}

void Lexer::skip_blanks() {
    while (at_ < text_.size()) {
        if (is_blank(text_[at_])) {
            step();
        } else if (text_.substr(at_, 2) == "/*") {
            const Place begin = place_;
            const std::size_t end = text_.find("*/", at_ + 2);
            if (end == std::string_view::npos) {
                refuse_at(begin, "this comment has no end: */ is missing");
            }
            while (at_ < end + 2) {
                step();
            }
        } else {
            return;
        }
    }
}

Token Lexer::next() {
    const Token taken = token_;
    skip_blanks();
    const std::size_t begin = at_;
    token_.at = place_;
    if (at_ < text_.size() && is_punctuation(text_[at_])) {
        step();
    } else {
        while (at_ < text_.size() && !is_blank(text_[at_]) && !is_punctuation(text_[at_]) &&
               text_.substr(at_, 2) != "/*") {
            step();
        }
    }
    token_.text = text_.substr(begin, at_ - begin);
    return taken;
}

bool Lexer::take_if(std::string_view text) {
    if (token_.text != text) {
        return false;
    }
    next();
    return true;
}

void Lexer::expect(std::string_view text, std::string_view what_for) {
    if (!take_if(text)) {
        unexpected(fmt::format("'{}' {}", text, what_for));
    }
}

bool Lexer::number_ahead() const {
    return as_number(token_.text).has_value();
}

double Lexer::number(std::string_view what, double low, double high) {
    const std::optional<double> value = as_number(token_.text);
    if (!value) {
        unexpected(fmt::format("{}, a number", what));
    }
    if (!(*value >= low && *value <= high)) {
        refuse_at(token_.at, fmt::format("{} is {}, allowed are {} .. {}", what, shown(token_.text),
                                         low, high));
    }
    next();
    return *value;
}

std::size_t Lexer::count(std::string_view what, std::size_t low, std::size_t high) {
    const Token token = token_;
    const double value = number(what, static_cast<double>(low), static_cast<double>(high));
    if (value != std::floor(value)) {
        refuse_at(token.at, fmt::format("{} is {}, not a whole number", what, shown(token.text)));
    }
    return static_cast<std::size_t>(value);
}

}  // namespace pxpl5::host::phigs
