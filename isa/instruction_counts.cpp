#include "isa/instruction_counts.hpp"

#include "isa/program.hpp"

namespace pxpl5::isa {

void InstructionCounts::add(Instruction in) {
    const std::uint32_t cycles = info(in.op).cycles(in.operands);
    ClassCounts& counts = classes[static_cast<std::size_t>(class_of(in.op))];
    ++counts.instructions;
    counts.cycles += cycles;
    port_cycles += in.op == Op::pixels_to_fb ? cycles : 0;
    backing_cycles += in.op == Op::bs_wait ? cycles : 0;
}

InstructionCounts& InstructionCounts::operator+=(const InstructionCounts& more) {
    for (std::size_t i = 0; i < classes.size(); ++i) {
        classes[i] += more.classes[i];
    }
    port_cycles += more.port_cycles;
    backing_cycles += more.backing_cycles;
    return *this;
}

ClassCounts InstructionCounts::total() const {
    ClassCounts sum;
    for (const ClassCounts& counts : classes) {
        sum += counts;
    }
    return sum;
}

bool runs_straight(std::span<const std::uint32_t> words) {
    for (std::size_t at = 0; at < words.size();) {
        const Op op = decode(words[at])->op;
        at += instruction_words(words[at]);
        // BSWAIT never changes the flow, and EOR at the end does not change it either.
        const bool goes_on = op == Op::bs_wait || (op == Op::eor && at == words.size());
        if ((info(op).effects & flow) != 0 && !goes_on) {
            return false;
        }
    }
    return true;
}

InstructionCounts count_text(std::span<const std::uint32_t> words) {
    InstructionCounts counts;
    for (std::size_t at = 0; at < words.size(); at += instruction_words(words[at])) {
        counts.add(*decode(words[at]));
    }
    return counts;
}

}  // namespace pxpl5::isa
