// Words to assembly text that assemble() turns into the same words.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "isa/executor.hpp"
#include "isa/instruction.hpp"

namespace pxpl5::isa {

/// One instruction, e.g. "TREEgeZERO :16  3 -5 120".
std::string disassemble(Instruction in, Coefficients coefficients);

struct ListingOptions {
    bool numbered =
        false;  ///< Word offset, raw word and cycles before each line; not for assemble().
};

/// One line per instruction. A word that does not decode, or whose coefficients are missing, prints
/// as a comment line with its value.
std::string disassemble(std::span<const std::uint32_t> words, ListingOptions options = {});

}  // namespace pxpl5::isa
