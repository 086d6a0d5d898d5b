// Which instruction set this program was built with.
#pragma once

#include <string_view>

namespace pxpl5::isa {

/// SHA-256 of instructions.def in hexadecimal: traces name it, since it decides what they mean.
std::string_view table_hash();

}  // namespace pxpl5::isa
