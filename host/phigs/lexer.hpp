// The words of a PPHIGS archive: splits the text, skips blanks and comments, knows places.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "host/phigs/archive.hpp"

namespace pxpl5::host::phigs {

/// A word, or one of { } ;. Empty at the end of the text.
struct Token {
    std::string_view text;
    Place at;
};

class Lexer {
  public:
    /// Both outlive the lexer.
    Lexer(std::string_view text, const std::string& file) : text_(text), file_(file) { next(); }

    const Token& peek() const { return token_; }
    /// Takes the token and goes on. Throws RequestError for a comment without end.
    Token next();
    bool at_end() const { return token_.text.empty(); }

    /// Takes the token if it is `text`.
    bool take_if(std::string_view text);
    /// Takes the token, which must be `text`; `what_for` says what it is for.
    void expect(std::string_view text, std::string_view what_for);
    /// Takes a number in [low, high]; `what` names it.
    double number(std::string_view what, double low, double high);
    /// Takes a whole number.
    std::size_t count(std::string_view what, std::size_t low, std::size_t high);
    /// True if a number comes next.
    bool number_ahead() const;

    /// Throws: the token ahead is not what is expected.
    [[noreturn]] void unexpected(std::string_view expected) const;
    [[noreturn]] void refuse_at(Place at, const std::string& text) const;

  private:
    void step();
    void skip_blanks();

    std::string_view text_;
    const std::string& file_;
    std::size_t at_ = 0;
    Place place_;
    Token token_;
};

}  // namespace pxpl5::host::phigs
