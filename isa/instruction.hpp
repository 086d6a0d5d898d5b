// The instruction table of instructions.def, with its encoder and its decoder.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace pxpl5::isa {

enum class Op : std::uint8_t {
#define PXPL5_OP(id, ...) id,
#include "isa/instructions.def"
#undef PXPL5_OP
};

enum class Source : std::uint8_t { published, derived, designed };

/// The state that an instruction may change; see the head of instructions.def.
enum Effects : std::uint16_t {
    none = 0,
    mem = 1,
    carry = 2,
    enable = 4,
    flag = 8,
    backing = 16,
    port = 32,
    flow = 64,
    all = 128,
};

/// Position of an operand in the instruction word; mask 0 if the row has no such operand.
struct OperandField {
    std::uint32_t mask = 0;
    int shift = 0;
};

/// A parsed bit picture. A malformed picture does not compile.
struct Pattern {
    std::uint32_t fixed_mask = 0;
    std::uint32_t fixed_bits = 0;
    OperandField a, b, n;

    constexpr explicit Pattern(std::string_view picture) {
        if (picture.size() != 32) {
            throw "a bit picture has 32 characters";
        }
        for (std::size_t i = 0; i < 32; ++i) {
            const char c = picture[i];
            const int shift = 31 - static_cast<int>(i);
            const std::uint32_t bit = 1U << static_cast<unsigned>(shift);
            if (c == 'a' || c == 'b' || c == 'n') {
                OperandField& field = c == 'a' ? a : c == 'b' ? b : n;
                if (field.mask != 0 && field.shift != shift + 1) {
                    throw "an operand's bits are contiguous";
                }
                field.mask |= bit;
                field.shift = shift;
            } else if (c == '0' || c == '1' || c == '-') {
                fixed_mask |= bit;
                fixed_bits |= c == '1' ? bit : 0;
            } else {
                throw "a bit picture holds 0, 1, -, a, b and n";
            }
        }
    }
};

struct Operands {
    std::uint32_t a = 0, b = 0, n = 0;
    friend bool operator==(const Operands&, const Operands&) = default;
};

struct Instruction {
    Op op{};
    Operands operands;
    friend bool operator==(const Instruction&, const Instruction&) = default;
};

/// The role of operand b.
enum class Role : std::uint8_t { absent, address, fraction, block, number };

constexpr Role role_of_b(std::string_view text) {
    const auto has = [text](std::string_view token) {
        return text.find(token) != std::string_view::npos;
    };
    return has("m{b}")    ? Role::address
           : has(">>{b}") ? Role::fraction
           : has("bs{b}") ? Role::block
           : has("#{b}")  ? Role::number
                          : Role::absent;
}

/// All facts about one instruction, except its effect on pixels.
struct OpInfo {
    std::string_view id, name, text, picture;
    Pattern pattern;
    int words;            ///< Number of coefficient words.
    std::uint32_t n_max;  ///< Widest field; 0 if there is no n.
    Effects effects;
    Source source;
    std::string_view doc, cycles_text;
    std::uint32_t (*at_a)(Operands);    ///< Bits of pixel memory used at m[a].
    std::uint32_t (*at_b)(Operands);    ///< Bits of pixel memory read at m[b].
    std::uint32_t (*cycles)(Operands);  ///< Modelled cycles at 40 MHz.
    Role b_role = role_of_b(text);

    /// True if the controller alone runs this row, without the pixels; see sequencer.hpp.
    constexpr bool is_control() const {
        return (effects & (mem | carry | enable | backing)) == 0 && pattern.a.mask == 0;
    }
};

constexpr std::string_view first_word(std::string_view text) {
    return text.substr(0, text.find(' '));
}

#define PXPL5_OPERAND_EXPRESSION(expression)                            \
    +[]([[maybe_unused]] Operands o) -> std::uint32_t {                 \
        [[maybe_unused]] const std::uint32_t a = o.a, b = o.b, n = o.n; \
        return static_cast<std::uint32_t>(expression);                  \
    }
inline constexpr std::array op_table = {
#define PXPL5_OP(id, text, bits, words, n_max, at_a, at_b, cycles, effects, source, doc) \
    OpInfo{#id,                                                                          \
           first_word(text),                                                             \
           text,                                                                         \
           bits,                                                                         \
           Pattern{bits},                                                                \
           words,                                                                        \
           n_max,                                                                        \
           static_cast<Effects>(effects),                                                \
           Source::source,                                                               \
           doc,                                                                          \
           #cycles,                                                                      \
           PXPL5_OPERAND_EXPRESSION(at_a),                                               \
           PXPL5_OPERAND_EXPRESSION(at_b),                                               \
           PXPL5_OPERAND_EXPRESSION(cycles)},
#include "isa/instructions.def"
#undef PXPL5_OP
};
#undef PXPL5_OPERAND_EXPRESSION

inline constexpr std::size_t op_count = op_table.size();

constexpr const OpInfo& info(Op op) {
    return op_table[static_cast<std::size_t>(op)];
}

/// The sections of instructions.def, in the order of the file.
enum class InstructionClass : std::uint8_t { enable, tree, memory, arithmetic, backing, control };
inline constexpr std::array<std::string_view, 6> class_names = {"enable",     "tree",    "memory",
                                                                "arithmetic", "backing", "control"};
inline constexpr std::size_t class_count = class_names.size();

/// Returns the class, which is the number in the top four bits of the instruction word.
constexpr InstructionClass class_of(Op op) {
    constexpr unsigned class_shift = 28;
    return static_cast<InstructionClass>(info(op).pattern.fixed_bits >> class_shift);
}
constexpr std::string_view name_of(InstructionClass which) {
    return class_names[static_cast<std::size_t>(which)];
}

/// True if every row has a class, and the rows of each class are adjacent.
constexpr bool classes_in_order() {
    std::size_t newest = 0;
    for (std::size_t i = 0; i < op_count; ++i) {
        const auto number = static_cast<std::size_t>(class_of(static_cast<Op>(i)));
        if (number < newest || number > newest + 1 || number >= class_count) {
            return false;
        }
        newest = number;
    }
    return newest + 1 == class_count;
}
static_assert(classes_in_order(), "a row's top four bits do not fit its section");

/// True if no word can decode as two instructions.
constexpr bool patterns_disjoint() {
    for (std::size_t i = 0; i < op_count; ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const Pattern &p = op_table[i].pattern, &q = op_table[j].pattern;
            if ((p.fixed_mask & q.fixed_mask & (p.fixed_bits ^ q.fixed_bits)) == 0) {
                return false;
            }
        }
    }
    return true;
}
static_assert(patterns_disjoint(), "two rows of instructions.def overlap");

/// True if the text of every row names exactly the operand fields of its picture.
constexpr bool texts_name_their_fields() {
    for (const OpInfo& row : op_table) {
        const OperandField fields[] = {row.pattern.a, row.pattern.b, row.pattern.n};
        const std::string_view tokens[] = {"{a}", "{b}", "{n}"};
        for (std::size_t k = 0; k < 3; ++k) {
            if ((row.text.find(tokens[k]) != std::string_view::npos) != (fields[k].mask != 0)) {
                return false;
            }
        }
        if ((row.n_max != 0) != (row.pattern.n.mask != 0)) {
            return false;
        }
    }
    return true;
}
static_assert(texts_name_their_fields(),
              "the text of a row does not name exactly its operand fields");

inline constexpr std::uint8_t no_row = 0xff;
inline constexpr unsigned op_byte_shift = 24;

/// Returns the row of each operation byte (the top byte of a word), or no_row. A picture with an
/// operand in its top byte does not compile.
constexpr std::array<std::uint8_t, 256> make_row_of_op_byte() {
    std::array<std::uint8_t, 256> rows{};
    rows.fill(no_row);
    for (std::size_t i = 0; i < op_count; ++i) {
        if (op_table[i].pattern.fixed_mask >> op_byte_shift != 0xffU) {
            throw "the top byte of a bit picture is fixed";
        }
        rows[op_table[i].pattern.fixed_bits >> op_byte_shift] = static_cast<std::uint8_t>(i);
    }
    return rows;
}
inline constexpr std::array<std::uint8_t, 256> row_of_op_byte = make_row_of_op_byte();
static_assert(op_count < no_row);

/// Returns the instruction word. Every operand must fit its field.
constexpr std::uint32_t encode(Instruction in) {
    const Pattern& p = info(in.op).pattern;
    const auto put = [](OperandField field, std::uint32_t value) {
        assert(value <= (field.mask >> static_cast<unsigned>(field.shift)));
        return value << static_cast<unsigned>(field.shift);
    };
    return p.fixed_bits | put(p.a, in.operands.a) | put(p.b, in.operands.b) |
           put(p.n, in.operands.n);
}

/// Returns the instruction of `word`, or nullopt if no row matches. Does not check the operands:
/// see check() in program.hpp.
constexpr std::optional<Instruction> decode(std::uint32_t word) {
    const auto get = [word](OperandField field) {
        return (word & field.mask) >> static_cast<unsigned>(field.shift);
    };
    const std::uint8_t row = row_of_op_byte[word >> op_byte_shift];
    if (row != no_row &&
        (word & op_table[row].pattern.fixed_mask) == op_table[row].pattern.fixed_bits) {
        const Pattern& p = op_table[row].pattern;
        return Instruction{static_cast<Op>(row), {get(p.a), get(p.b), get(p.n)}};
    }
    return std::nullopt;
}

}  // namespace pxpl5::isa
