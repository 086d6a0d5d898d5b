// The instructions of a triangle program, in order, with their word offsets.
//
// The Graphics Processors emit every triangle as this sequence. A Renderer that recognizes the
// sequence may run it as one step. Word offsets and instructions:
//
//    0  SETENABS
//    1  TREEgeZERO :n      A B C     first edge; n is 16, 24 or 32, independently per edge
//    5  TREEgeZERO :n      A B C     second edge
//    9  TREEgeZERO :n      A B C     third edge
//   13  TREEltMEM   z      A B C     depth test ...
//   17  TREEintoMEM z      A B C     ... and store, of the same plane
//   21  TREEintoMEM normal_x  A B C
//   25  TREEintoMEM normal_y  A B C
//   29  TREEintoMEM normal_z  A B C
//   33  IMMintoMEM  surface  #number
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "isa/contract/region_layout.hpp"
#include "isa/instruction.hpp"

namespace pxpl5::isa::triangle {

// Offsets of the instruction words. Coefficients A, B, C are at +1, +2, +3.
inline constexpr std::size_t at_enable = 0;
inline constexpr std::array<std::size_t, 3> at_edge = {1, 5, 9};
inline constexpr std::size_t at_z_test = 13;
inline constexpr std::size_t at_z_store = 17;
inline constexpr std::array<std::size_t, 3> at_normal = {21, 25, 29};
inline constexpr std::size_t at_surface = 33;
inline constexpr std::size_t word_count = 34;
inline constexpr std::size_t instruction_count = 10;

/// Permitted widths of an edge's TREEgeZERO, in bits.
inline constexpr std::array<std::uint32_t, 3> edge_widths = {16, 24, 32};

/// Returns the word of a TREE instruction on a whole field that drops `fraction` bits.
constexpr std::uint32_t field_word(Op op, region::Field field, std::uint32_t fraction) {
    return encode({op, {field.address, fraction, field.width}});
}

// The instruction words.
inline constexpr std::uint32_t enable_word = encode({Op::set_enabs, {}});
constexpr std::uint32_t edge_word(std::uint32_t width) {
    return encode({Op::tree_ge_zero, {0, 0, width}});
}
inline constexpr std::uint32_t z_test_word =
    field_word(Op::tree_lt_mem, region::z, region::z_fraction_bits);
inline constexpr std::uint32_t z_store_word =
    field_word(Op::tree_into_mem, region::z, region::z_fraction_bits);
inline constexpr std::array<std::uint32_t, 3> normal_words = {
    field_word(Op::tree_into_mem, region::normal_x, region::normal_fraction_bits),
    field_word(Op::tree_into_mem, region::normal_y, region::normal_fraction_bits),
    field_word(Op::tree_into_mem, region::normal_z, region::normal_fraction_bits),
};
/// Returns the word that stores `number` (1 + surface index) as the pixel's surface.
constexpr std::uint32_t surface_word(std::uint32_t number) {
    return encode({Op::imm_into_mem, {region::surface.address, number, region::surface.width}});
}

/// True if `words` begins with a triangle program: all instruction words are those above, and the
/// z test and the z store have the same plane. At least word_count words must be readable.
constexpr bool matches(const std::uint32_t* words) {
    bool same = words[at_enable] == enable_word && words[at_z_test] == z_test_word &&
                words[at_z_store] == z_store_word;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t edge = words[at_edge[k]];
        same = same && words[at_normal[k]] == normal_words[k] &&
               words[at_z_test + 1 + k] == words[at_z_store + 1 + k] &&
               (edge == edge_word(edge_widths[0]) || edge == edge_word(edge_widths[1]) ||
                edge == edge_word(edge_widths[2]));
    }
    // Bits 15..8 of an IMMintoMEM word are the number.
    return same && (words[at_surface] & ~0x0000FF00U) == surface_word(0);
}

}  // namespace pxpl5::isa::triangle
