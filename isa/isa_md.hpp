// ISA.md: the instruction set as a document, made from the rows of instructions.def.
#pragma once

#include <string>

namespace pxpl5::isa {

/// The text of ISA.md.
std::string isa_markdown();

}  // namespace pxpl5::isa
