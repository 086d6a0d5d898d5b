// Facts about the text of a region program, computed when the executor is compiled.
#pragma once

#include <cstddef>
#include <cstdint>

#include "isa/instruction.hpp"
#include "renderer_firmware/programs/text.hpp"

namespace pxpl5::renderer::fast {

/// Joins texts into one text.
template <std::size_t... words, std::size_t... open>
constexpr auto joined(const programs::Text<words, open>&... parts) {
    programs::Text<(words + ...), (open + ...)> all{};
    std::size_t word_count = 0, open_count = 0;
    const auto append = [&](const auto& part) {
        for (const programs::Open& coefficient : part.open) {
            all.open[open_count++] = {coefficient.name, word_count + coefficient.word};
        }
        for (const std::uint32_t word : part.words) {
            all.words[word_count++] = word;
        }
    };
    (append(parts), ...);
    return all;
}

template <const auto& text>
struct Facts {
    static constexpr std::size_t word_count = text.words.size();

    /// True if the text leaves the coefficient `word` open.
    static constexpr bool is_open(std::size_t word) {
        for (const programs::Open& coefficient : text.open) {
            if (coefficient.word == word) {
                return true;
            }
        }
        return false;
    }

    static constexpr std::size_t count_instructions() {
        std::size_t count = 0;
        for (std::size_t word = 0; word < word_count; word = behind(word)) {
            ++count;
        }
        return count;
    }
    static constexpr std::size_t instruction_count = count_instructions();

    /// Returns the word offset of instruction i.
    static constexpr std::size_t word_of(std::size_t i) {
        std::size_t word = 0;
        while (i-- != 0) {
            word = behind(word);
        }
        return word;
    }
    static constexpr isa::Instruction instruction(std::size_t i) {
        return *isa::decode(text.words[word_of(i)]);
    }
    static constexpr bool has(std::size_t i, int effects) {
        return (isa::info(instruction(i).op).effects & effects) != 0;
    }
    static constexpr bool any_has(int effects) {
        for (std::size_t i = 0; i < instruction_count; ++i) {
            if (has(i, effects)) {
                return true;
            }
        }
        return false;
    }

    /// True if instruction i writes column k, bits 32 k .. 32 k + 31 of memory.
    static constexpr bool writes(std::size_t i, std::size_t k) {
        const isa::Operands o = instruction(i).operands;
        const std::size_t end = o.a + isa::info(instruction(i).op).at_a(o);
        return has(i, isa::mem) && o.a < 32 * (k + 1) && end > 32 * k;
    }
    static constexpr bool any_writes(std::size_t k) {
        for (std::size_t i = 0; i < instruction_count; ++i) {
            if (writes(i, k)) {
                return true;
            }
        }
        return false;
    }

    /// True if instruction i acts on disabled pixels, or changes the enables.
    static constexpr bool is_border(std::size_t i) { return has(i, isa::enable | isa::all); }

    /// True if column k is written between the last border before instruction i and i.
    static constexpr bool is_pending(std::size_t i, std::size_t k) {
        while (i-- != 0 && !is_border(i)) {
            if (writes(i, k)) {
                return true;
            }
        }
        return false;
    }

    /// True if the carry of instruction i is overwritten before any use.
    static constexpr bool is_carry_unseen(std::size_t i) {
        while (++i < instruction_count && !is_border(i)) {
            if (has(i, isa::carry)) {
                return true;
            }
        }
        return false;
    }

  private:
    static constexpr std::size_t behind(std::size_t word) {
        const isa::OpInfo& row = isa::info(isa::decode(text.words[word])->op);
        return word + 1 + static_cast<std::size_t>(row.words);
    }
};

}  // namespace pxpl5::renderer::fast
