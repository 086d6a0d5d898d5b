// Assembly text to words. The syntax of an instruction is its row's text in instructions.def.
//
//   .def z 8                     ; a name for a number; m[z], m[z+8] and z itself then work
//   again:                       ; a label: usable as K of CALL and SKIPIFNONE
//     TREEltMEM m[z]:24 >>8  3 -5 $depth   ; coefficients follow; $name is a parameter
//     IMMintoMEM m[z+2*8]:8 #$level
//
// Numbers are decimal or 0x hexadecimal; expressions are sums, differences and products of numbers
// and names. An address may be written m8 or m[expression].
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "isa/program.hpp"

namespace pxpl5::isa {

/// Thrown for text that is not a program; `what` names line, column, what was found and what was
/// expected.
struct AssemblyError : std::runtime_error {
    AssemblyError(const std::string& what, std::size_t line_number, std::size_t column_number)
        : std::runtime_error(what), line(line_number), column(column_number) {}
    std::size_t line, column;  ///< From 1.
};

inline constexpr std::size_t max_assembly_bytes = std::size_t{1} << 24;

/// Assembles `text`. Operand ranges of the rows are checked; control flow is left to check().
/// Throws AssemblyError.
Program assemble(std::string_view text);

}  // namespace pxpl5::isa
