// Turns assembly text into words. instructions.def holds the syntax of each instruction.
// ASSEMBLER.md describes the language, with examples.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "isa/program.hpp"

namespace pxpl5::isa {

/// Thrown for text that is not a program. The text names the line, the column, the part that was
/// found and the part that was expected.
struct AssemblyError : std::runtime_error {
    AssemblyError(const std::string& what, std::size_t line_number, std::size_t column_number)
        : std::runtime_error(what), line(line_number), column(column_number) {}
    std::size_t line, column;  ///< Both from 1.
};

inline constexpr std::size_t max_assembly_bytes = std::size_t{1} << 24;

/// Assembles `text`. Checks the operands of each instruction, but not the control flow: call
/// check() for that. Throws AssemblyError.
Program assemble(std::string_view text);

/// Returns the syntax of an instruction with its coefficients, for example "TREEgeZERO :n A B C".
std::string syntax_of(const OpInfo& row);

}  // namespace pxpl5::isa
