// Group enable, fast: the enable bits.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/enable.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

/// Returns bit m[a] of the vector at `at` in `block`, one bit per lane.
HWY_INLINE std::uint32_t memory_bits(const Block& block, std::size_t at, std::uint32_t a) {
    return bits_of(equal(Field<Narrow>(a, 1).load(block, at), number<Narrow>(1)));
}

HWY_INLINE std::uint32_t enabled_bits(const Board& board, std::size_t b, std::size_t at) {
    return load_bits(board.pixels.enable, b * hal::block_pixels + at);
}

void set_enabs(Board& board, BlockRange range, Operands, Coefficients) {
    set_everywhere(board, range, [](std::size_t, std::size_t) PXPL5_BODY { return all_lanes; });
}

void clr_enabs(Board& board, BlockRange range, Operands, Coefficients) {
    set_everywhere(board, range, [](std::size_t, std::size_t) PXPL5_BODY { return 0U; });
}

void inv_enabs(Board& board, BlockRange range, Operands, Coefficients) {
    set_everywhere(board, range, [&board](std::size_t b, std::size_t at) PXPL5_BODY {
        return ~enabled_bits(board, b, at);
    });
}

void enab_into_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    const Field<Narrow> bit(o.a, 1);
    for (std::size_t b = range.first; b < range.end; ++b) {
        for (std::size_t at = 0; at < hal::block_pixels; at += lanes) {
            const M enabled = mask_of(enabled_bits(board, b, at));
            bit.store(board.pixels.blocks[b], at, {one_where(enabled)}, mask_of(all_lanes));
        }
    }
}

void mem_into_enab(Board& board, BlockRange range, Operands o, Coefficients) {
    set_everywhere(board, range, [&board, o](std::size_t b, std::size_t at) PXPL5_BODY {
        return memory_bits(board.pixels.blocks[b], at, o.a);
    });
}

void enab_and_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    keep_where(board, range, [&board, o](std::size_t b, std::size_t at) PXPL5_BODY {
        return mask_of(memory_bits(board.pixels.blocks[b], at, o.a));
    });
}

void enab_and_not_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    keep_where(board, range, [&board, o](std::size_t b, std::size_t at) PXPL5_BODY {
        return mask_of(~memory_bits(board.pixels.blocks[b], at, o.a) & all_lanes);
    });
}

void enab_or_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    set_everywhere(board, range, [&board, o](std::size_t b, std::size_t at) PXPL5_BODY {
        return enabled_bits(board, b, at) | memory_bits(board.pixels.blocks[b], at, o.a);
    });
}

void enab_and_carry(Board& board, BlockRange range, Operands, Coefficients) {
    keep_where(board, range, [&board](std::size_t b, std::size_t at) PXPL5_BODY {
        return mask_of(load_bits(board.pixels.carry, b * hal::block_pixels + at));
    });
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
