// Region programs, fused: runs stretches of their texts as one pass over tiles, in registers.
//
// This file does not restate the texts. The compiler reads their words from programs/, and each
// instruction uses the code of its row in fused-inl.hpp. The compiler sees the positions of all
// operands, and which writes the next instruction overwrites. The only exception is run_power().
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/fused.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/fused-inl.hpp"
#include "renderer_firmware/fast/text_facts.hpp"
#include "renderer_firmware/programs/texts.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

namespace texts = pxpl5::renderer::programs;

using Words = std::span<const std::uint32_t>;
using EveryColumn = std::make_index_sequence<hal::column_count>;

// ---- on one vector

/// Commits the stretch of writes ahead of instruction i.
template <const auto& text, std::size_t i, std::size_t... k>
HWY_INLINE void commit(Pixels& p, std::index_sequence<k...>) {
    const auto commit_pending = [&]<std::size_t column>() PXPL5_BODY {
        if constexpr (Facts<text>::is_pending(i, column)) {
            p.commit<column>();
        }
    };
    (commit_pending.template operator()<k>(), ...);
}

/// Runs instruction i of `text`; the words of `text` are at `words`.
template <const auto& text, std::size_t i>
HWY_INLINE void run_instruction(Pixels& p, const std::int32_t* words) {
    using F = Facts<text>;
    constexpr isa::Instruction in = F::instruction(i);
    constexpr std::size_t coefficient = F::word_of(i) + 1;
    std::int32_t k = 0;
    if constexpr (isa::info(in.op).words == 1) {
        k = F::is_open(coefficient) ? words[coefficient]
                                    : static_cast<std::int32_t>(text.words[coefficient]);
    }
    if constexpr (F::is_border(i)) {
        commit<text, i>(p, EveryColumn());
    }
    const M carry = p.carry;
    run_row<in.operands>(Row<in.op>(), p, k);
    if constexpr (F::is_carry_unseen(i)) {
        p.carry = carry;
    }
}

template <const auto& text, std::size_t... i>
HWY_INLINE void run_text(Pixels& p, const std::int32_t* words, std::index_sequence<i...>) {
    (run_instruction<text, i>(p, words), ...);
    commit<text, sizeof...(i)>(p, EveryColumn());
}

/// Loads the vector of pixels at `index`; its word 0 is at `first`.
HWY_INLINE Pixels load(const PixelArray& pixels, const std::uint32_t* first, std::size_t index) {
    Pixels p;
    for (std::size_t k = 0; k < hal::column_count; ++k) {
        p.columns[k] = p.kept[k] = hn::Load(D(), first + k * hal::block_pixels);
    }
    p.enable = mask_of(load_bits(pixels.enable, index));
    p.carry = mask_of(load_bits(pixels.carry, index));
    return p;
}

/// Stores the columns that `text` changed.
template <const auto& text, std::size_t... k>
HWY_INLINE void store(PixelArray& pixels, const Pixels& p, std::uint32_t* first, std::size_t index,
                      std::index_sequence<k...>) {
    const auto store_changed = [&]<std::size_t column>() PXPL5_BODY {
        if constexpr (Facts<text>::any_writes(column)) {
            hn::Store(p.columns[column], D(), first + column * hal::block_pixels);
        }
    };
    (store_changed.template operator()<k>(), ...);
    if constexpr (Facts<text>::any_has(isa::enable)) {
        store_bits(pixels.enable, index, bits_of(p.enable));
    }
    if constexpr (Facts<text>::any_has(isa::carry)) {
        store_bits(pixels.carry, index, bits_of(p.carry));
    }
}

// ---- on tiles

/// Calls body(word 0, index) for each vector of `tiles`.
template <typename Body>
HWY_INLINE void for_each_vector(Tiles tiles, const Body& body) {
    for (const Tile& tile : tiles) {
        for (std::size_t i = 0; i < hal::tile_pixels; i += lanes) {
            body(tile.first + i, tile.index + i);
        }
    }
}

template <const auto& text>
void run(Board& board, Tiles tiles, Words stream) {
    using F = Facts<text>;
    // A copy, so that stores to pixels cannot change the words.
    std::int32_t words[F::word_count];
    std::memcpy(words, stream.data(), sizeof words);
    for_each_vector(tiles, [&](std::uint32_t* first, std::size_t index) PXPL5_BODY {
        Pixels p = load(board.pixels, first, index);
        run_text<text>(p, words, std::make_index_sequence<F::instruction_count>());
        store<text>(board.pixels, p, first, index, EveryColumn());
    });
}

/// Returns the number of words of `text` if `stream` begins with `text`, else 0.
template <const auto& text>
std::size_t match(Words stream) {
    using F = Facts<text>;
    if (stream.size() < F::word_count) {
        return 0;
    }
    for (std::size_t i = 0; i < F::word_count; ++i) {
        if (stream[i] != text.words[i] && !F::is_open(i)) {
            return 0;
        }
    }
    return F::word_count;
}

// ---- powers: any sequence of squares and products with the base
//
// Each step leaves the upper half of a 16-bit product in both halves of U. With the factors in both
// halves of a lane, a step is one multiplication of halves.

using Halves = hn::RepartitionToNarrow<D>;

constexpr isa::Operands square_operands = Facts<texts::square>::instruction(0).operands;
constexpr isa::Operands base_operands = Facts<texts::times_base>::instruction(0).operands;
constexpr std::uint32_t place_u = square_operands.a, place_base = base_operands.b;
constexpr std::array<std::uint32_t, 2> power_step(std::uint32_t factor) {
    return {isa::encode({isa::Op::mul_mem, {place_u, factor, 16}}),
            isa::encode({isa::Op::mem_into_mem, {place_u, place_u + 16, 16}})};
}
static_assert(texts::square.words == power_step(place_u) &&
                  texts::times_base.words == power_step(place_base) && place_u % 32 == 0 &&
                  place_base % 32 == 0,
              "the texts are what run_power() does");

/// Steps of one call; further steps need another call.
inline constexpr std::size_t max_power_steps = 32;

std::size_t match_power(Words stream) {
    std::size_t taken = 0;
    for (std::size_t i = 0; i < max_power_steps; ++i) {
        const Words rest = stream.subspan(taken);
        const std::size_t more = match<texts::square>(rest) + match<texts::times_base>(rest);
        if (more == 0) {
            break;
        }
        taken += more;
    }
    return taken;
}

/// Returns the lower half of each lane in both halves of the lane.
HWY_INLINE hn::Vec<Halves> in_both_halves(V v) {
    return hn::BitCast(Halves(), hn::Or(hn::ShiftLeft<16>(v), hn::And(v, splat(0xFFFF))));
}

void run_power(Board& board, Tiles tiles, Words stream) {
    constexpr std::size_t step_words = texts::square.words.size();
    const std::size_t step_count = stream.size() / step_words;
    std::uint32_t squares = 0;  // Bit i is set if step i is a square.
    for (std::size_t i = 0; i < step_count; ++i) {
        squares |= std::uint32_t{stream[i * step_words] == texts::square.words[0]} << i;
    }
    for_each_vector(tiles, [&](std::uint32_t* first, std::size_t index) PXPL5_BODY {
        std::uint32_t* column = first + place_u / 32 * hal::block_pixels;
        const V old = hn::Load(D(), column);
        auto power = in_both_halves(old);
        const auto base =
            in_both_halves(hn::Load(D(), first + place_base / 32 * hal::block_pixels));
        for (std::size_t i = 0; i < step_count; ++i) {
            power = hn::MulHigh(power, (squares >> i & 1) != 0 ? power : base);
        }
        const M enable = mask_of(load_bits(board.pixels.enable, index));
        hn::Store(hn::IfThenElse(enable, hn::BitCast(D(), power), old), D(), column);
    });
}

// ---- the stretches that run as one; the longest match runs

constexpr auto light = joined(texts::ambient, texts::normal);
constexpr auto dot = joined(texts::dot_first_x, texts::dot_next_y, texts::dot_next_z);
constexpr auto scaled_diffuse = joined(texts::scale, texts::diffuse);
constexpr auto scaled_highlight = joined(texts::scale, texts::visible);
constexpr auto scaled_base = joined(scaled_highlight, texts::keep_base);
constexpr auto dot_diffuse = joined(dot, scaled_diffuse);
constexpr auto dot_highlight = joined(dot, scaled_highlight);
constexpr auto dot_base = joined(dot, scaled_base);
constexpr auto colored_finish = joined(texts::color_first, texts::finish);
constexpr auto summed_4 = joined(texts::sum_spread_4, texts::sum_add_4);
constexpr auto summed_16 = joined(texts::sum_spread_16, texts::sum_add_16);

template <const auto& text>
constexpr Fused fused{match<text>, run<text>};

std::span<const Fused> fused_programs() {
    static constexpr Fused all[] = {
        fused<texts::prologue>,
        fused<texts::shut_door>,
        fused<texts::open_door>,
        fused<texts::cover>,
        fused<light>,
        fused<texts::ambient>,
        fused<texts::unlit>,
        fused<texts::length>,
        fused<texts::inverse>,
        fused<dot_diffuse>,
        fused<dot_base>,
        fused<dot_highlight>,
        fused<texts::dot_first_x>,
        fused<texts::dot_first_y>,
        fused<texts::dot_first_z>,
        fused<texts::dot_next_y>,
        fused<texts::dot_next_z>,
        fused<scaled_diffuse>,
        fused<scaled_base>,
        fused<scaled_highlight>,
        {match_power, run_power},
        fused<texts::gloss>,
        fused<colored_finish>,
        fused<texts::color_first>,
        fused<texts::color_next>,
        fused<texts::limit_light>,
        fused<texts::rim_view>,
        fused<texts::rim>,
        fused<texts::gray>,
        fused<texts::enable_covered>,
        fused<texts::finish>,
        fused<summed_4>,
        fused<summed_16>,
        fused<texts::sum_spread_4>,
        fused<texts::sum_spread_16>,
    };
    return all;
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
