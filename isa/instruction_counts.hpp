// Counts the instructions of a program, or of a run, by class.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "isa/instruction.hpp"

namespace pxpl5::isa {

struct ClassCounts {
    std::uint64_t instructions = 0;
    std::uint64_t cycles = 0;  ///< Modelled, 40 MHz.
    ClassCounts& operator+=(const ClassCounts& more) {
        instructions += more.instructions;
        cycles += more.cycles;
        return *this;
    }
    friend bool operator==(const ClassCounts&, const ClassCounts&) = default;
};

/// Counts by class. The last two members are the part in which the array only waits.
struct InstructionCounts {
    std::array<ClassCounts, class_count> classes{};  ///< In the order of InstructionClass.
    std::uint64_t port_cycles = 0;                   ///< Cycles of PIXELSTOFB.
    std::uint64_t backing_cycles = 0;                ///< Cycles of BSWAIT.

    void add(Instruction in);
    InstructionCounts& operator+=(const InstructionCounts& more);
    ClassCounts total() const;
    friend bool operator==(const InstructionCounts&, const InstructionCounts&) = default;
};

/// True if every instruction of a checked program runs exactly once, for all contents of the
/// pixels.
bool runs_straight(std::span<const std::uint32_t> words);

/// Counts each instruction of a checked program once. This equals a run if runs_straight().
InstructionCounts count_text(std::span<const std::uint32_t> words);

}  // namespace pxpl5::isa
