// A program: instruction words, what a valid one obeys, and one with open parameters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "isa/instruction.hpp"

namespace pxpl5::isa {

inline constexpr std::size_t max_program_words = std::size_t{1} << 26;
inline constexpr std::uint32_t max_fraction_bits = 63;
inline constexpr std::size_t max_loop_depth = 8;
inline constexpr std::size_t max_call_depth = 8;

/// What is wrong with a program: the first offending instruction's word offset, and one sentence
/// that names the field and both values.
struct ProgramError {
    std::size_t word = 0;
    std::string text;
};

/// Facts of a valid program, each instruction of the text counted once.
struct ProgramFacts {
    std::size_t instructions = 0;
    std::uint64_t cycles = 0;  ///< Modelled cycles at 40 MHz, if every instruction runs once.
    bool has_flow = false;     ///< Holds a CALL, LOOP or SKIPIFNONE: counts of a run may differ.
};

struct CheckResult {
    ProgramFacts facts;  ///< Meaningful without error.
    std::optional<ProgramError> error;
    bool ok() const { return !error.has_value(); }
};

/// Checks a received stream. In a valid program
/// - every word decodes and has its coefficient words; n is 1..n_max; fields end within the 208
///   bits; fractions are at most 63, blocks at most 127;
/// - CALL and SKIPIFNONE reach an instruction of the program, or its end: CALL outside loops,
///   SKIPIFNONE ahead and in the same loop; RET stands outside loops;
/// - loops balance and nest 8 deep at most;
/// - a field or block under transfer is left alone until BSWAIT, and no transfer is open where
///   control may leave the straight line, nor at the end.
CheckResult check(std::span<const std::uint32_t> words);

/// Words of the instruction at `words[0]`: 1 + its coefficients; 0 if it does not decode.
inline std::size_t instruction_words(std::uint32_t word) {
    const std::uint8_t row = row_of_op_byte[word >> op_byte_shift];
    return row == no_row ? 0 : 1 + static_cast<std::size_t>(op_table[row].words);
}

/// Thrown by Program::bind; names the parameter.
struct ParameterError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

using Parameters = std::map<std::string, std::int64_t, std::less<>>;

/// Assembled words, some of which wait for a parameter's value.
struct Program {
    /// Where the value of `$name` goes: a whole coefficient word, or the #-operand of an
    /// instruction.
    struct Patch {
        std::string name;
        std::size_t word = 0;
        bool is_operand = false;  ///< True: the b field of the instruction at `word`.
        friend bool operator==(const Patch&, const Patch&) = default;
    };

    std::vector<std::uint32_t> words;
    std::vector<Patch> patches;
    std::map<std::string, std::size_t, std::less<>> labels;  ///< Word offset per label.

    /// The words with every parameter filled in.
    /// Throws ParameterError if a parameter lacks a value, a value has no parameter, or a value
    /// does not fit (coefficients: -2^31..2^32-1; #-operands: 0..255).
    std::vector<std::uint32_t> bind(const Parameters& values) const;
};

}  // namespace pxpl5::isa
