// Turns words into assembly text. assemble() turns the text into the same words.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "isa/executor.hpp"
#include "isa/instruction.hpp"

namespace pxpl5::isa {

/// Returns the text of one instruction, for example "TREEgeZERO :16  3 -5 120".
std::string disassemble(Instruction in, Coefficients coefficients);

struct ListingOptions {
    bool numbered =
        false;  ///< Precede each line by word offset, raw word and cycles. assemble() refuses this.
};

/// Returns one line per instruction. A word that does not decode, or whose coefficients are
/// missing, becomes a comment line with its value.
std::string disassemble(std::span<const std::uint32_t> words, ListingOptions options = {});

}  // namespace pxpl5::isa
