// One line of assembly text, and the reading position in it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "isa/instruction.hpp"

namespace pxpl5::isa {

/// Reads the parts of a line from left to right. Throws AssemblyError with line and column if the
/// next part is not the expected one.
class AssemblyLine {
  public:
    /// text    The line without its comment. Outlives the AssemblyLine.
    /// number  Of the line, from 1.
    AssemblyLine(std::string_view text, std::size_t number) : text_(text), number_(number) {}

    [[noreturn]] void fail(std::size_t column, const std::string& what) const;

    /// Fails at the next part: names the part and what is expected instead.
    [[noreturn]] void fail_expecting(std::string_view expected);

    /// From now on, fail_expecting() also prints the syntax of this instruction.
    void set_instruction(const OpInfo& row) { row_ = &row; }

    void skip_blanks();
    bool at_end();
    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    std::size_t column() const { return at_; }  ///< From 0.

    bool accept(std::string_view token);
    void expect(std::string_view token);

    /// Skips blanks and reads a name: a letter or _, then letters, digits and _.
    std::string_view name(std::string_view expected);
    bool at_name() const;

    /// Reads a decimal number, or a hexadecimal one that begins with 0x.
    std::int64_t number();

  private:
    std::string found() const;
    int digit(std::int64_t base) const;

    std::string_view text_;
    std::size_t number_;
    std::size_t at_ = 0;
    const OpInfo* row_ = nullptr;
};

}  // namespace pxpl5::isa
