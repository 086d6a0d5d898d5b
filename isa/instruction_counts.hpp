// Instruction counts: what a program, or a run of one, is made of, by class.
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

/// By class; and of these the cycles in which the array only waits.
struct InstructionCounts {
    std::array<ClassCounts, class_count> classes{};  ///< In the order of InstructionClass.
    std::uint64_t port_cycles = 0;                   ///< Of PIXELSTOFB.
    std::uint64_t backing_cycles = 0;                ///< Of BSWAIT.

    void add(Instruction in);
    InstructionCounts& operator+=(const InstructionCounts& more);
    ClassCounts total() const;
    friend bool operator==(const InstructionCounts&, const InstructionCounts&) = default;
};

/// Whether every instruction of a checked program runs exactly once, whatever the pixels hold.
bool runs_straight(std::span<const std::uint32_t> words);

/// Each instruction of a checked program once: what a run of it executes if it runs straight.
InstructionCounts count_text(std::span<const std::uint32_t> words);

}  // namespace pxpl5::isa
