// Instruction streams from the bytes of an input.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

/// Takes a first byte. If its low bit is 0, the rest are little-endian words. Otherwise, the rest
/// chooses instructions with operands that fit, so that check() accepts most streams.
std::vector<std::uint32_t> stream_words(Bytes& bytes);

}  // namespace pxpl5::fuzz
