// Programs: instruction words, the rules of valid programs, and programs with parameters.
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

/// The first error of a program: the word offset of the wrong instruction, and one sentence that
/// names the field and both values.
struct ProgramError {
    std::size_t word = 0;
    std::string text;
};

/// Facts about a valid program. Each instruction of the text counts once.
struct ProgramFacts {
    std::size_t instructions = 0;
    std::uint64_t cycles = 0;  ///< Modelled cycles at 40 MHz, if every instruction runs once.
    bool has_flow = false;     ///< Contains CALL, LOOP or SKIPIFNONE: a run may have other counts.
};

struct CheckResult {
    ProgramFacts facts;  ///< Valid if there is no error.
    std::optional<ProgramError> error;
    bool ok() const { return !error.has_value(); }
};

/// Checks a received stream. In a valid program
/// - every word decodes and has its coefficient words; n is 1..n_max; fields are within the 208
///   bits; fractions are at most 63, blocks at most 127;
/// - CALL and SKIPIFNONE reach an instruction of the program, or its end: CALL outside loops,
///   SKIPIFNONE ahead and in the same loop; RET is outside loops;
/// - loops balance and nest 8 deep at most;
/// - no instruction uses a field or block under transfer before BSWAIT; no transfer is open at a
///   jump, at the edge of a loop, or at the end.
CheckResult check(std::span<const std::uint32_t> words);

/// Returns the length of the instruction that begins with `word`, or 0 if no row matches.
inline std::size_t instruction_words(std::uint32_t word) {
    const std::uint8_t row = row_of_op_byte[word >> op_byte_shift];
    return row == no_row ? 0 : 1 + static_cast<std::size_t>(op_table[row].words);
}

/// Thrown by Program::bind. The text names the parameter.
struct ParameterError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

using Parameters = std::map<std::string, std::int64_t, std::less<>>;

/// Assembled words. Program::bind() fills in the values of the parameters.
struct Program {
    /// A use of the parameter `$name`: a whole coefficient word, or the #-operand of an
    /// instruction.
    struct Patch {
        std::string name;
        std::size_t word = 0;
        bool is_operand = false;  ///< True: the b field of the instruction at `word`.
        friend bool operator==(const Patch&, const Patch&) = default;
    };

    std::vector<std::uint32_t> words;
    std::vector<Patch> patches;
    std::map<std::string, std::size_t, std::less<>> labels;  ///< Word offset of each label.

    /// Returns the words with the values of all parameters.
    /// Throws ParameterError if a parameter has no value, a value has no parameter, or a value is
    /// out of range (coefficients: -2^31..2^32-1; #-operands: 0..255).
    std::vector<std::uint32_t> bind(const Parameters& values) const;
};

}  // namespace pxpl5::isa
