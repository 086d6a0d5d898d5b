// Generates ISA.md from the rows of instructions.def.
#pragma once

#include <string>

namespace pxpl5::isa {

/// Returns the text of ISA.md.
std::string isa_markdown();

}  // namespace pxpl5::isa
