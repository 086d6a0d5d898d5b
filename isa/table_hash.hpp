// Identifies the instruction set of this build.
#pragma once

#include <string_view>

namespace pxpl5::isa {

/// Returns the SHA-256 of the rows of instructions.def, without their sentences, in hexadecimal.
/// Traces record the hash, because the rows define the meaning of recorded words.
std::string_view table_hash();

}  // namespace pxpl5::isa
