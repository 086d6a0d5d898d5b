// Group memory, fast: moves, combinations and comparisons of fields.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/memory.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/values-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

/// m[a] = combine(m[a], m[b]), n bits each.
template <typename Combine>
HWY_INLINE void combine_fields(Board& board, BlockRange range, Operands o, const Combine& combine) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> to(o.a, o.n), from(o.b, o.n);
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          Block& block = board.pixels.blocks[b];
                          to.store(block, at, combine(to.load(block, at), from.load(block, at)),
                                   mask_of(bits));
                      });
    });
}

/// m[a : a+n) = value.
HWY_INLINE void store_value(Board& board, BlockRange range, Operands o, std::uint64_t value) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> to(o.a, o.n);
        const N stored = number<N>(value);
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          to.store(board.pixels.blocks[b], at, stored, mask_of(bits));
                      });
    });
}

/// Keeps the pixels where test(m[a], m[b]) is true, n bits each. `flip` inverts the top bits first,
/// which makes an unsigned comparison signed.
template <typename Test>
HWY_INLINE void test_fields(Board& board, BlockRange range, Operands o, std::uint64_t flip,
                            const Test& test) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> left(o.a, o.n), right(o.b, o.n);
        const N top = number<N>(flip);
        keep_where(board, range, [&](std::size_t b, std::size_t at) PXPL5_BODY {
            const Block& block = board.pixels.blocks[b];
            return test(left.load(block, at) ^ top, right.load(block, at) ^ top);
        });
    });
}

/// Keeps the pixels where test(m[a], K) is true, on n bits.
template <typename Test>
HWY_INLINE void test_constant(Board& board, BlockRange range, Operands o, Coefficients k,
                              std::uint64_t flip, const Test& test) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> left(o.a, o.n);
        const N top = number<N>(flip);
        const N right = number<N>((static_cast<std::uint64_t>(std::int64_t{k[0]}) & ones(o.n)));
        keep_where(board, range, [&](std::size_t b, std::size_t at) PXPL5_BODY {
            return test(left.load(board.pixels.blocks[b], at) ^ top, right ^ top);
        });
    });
}

void mem_into_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    combine_fields(board, range, o, [](auto, auto from) PXPL5_BODY { return from; });
}
void const_into_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    store_value(board, range, o, static_cast<std::uint64_t>(std::int64_t{k[0]}));
}
void imm_into_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    store_value(board, range, o, o.b);
}
void clear_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    store_value(board, range, o, 0);
}
void not_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> memory(o.a, o.n);
        const N flip = number<N>(ones(o.n));
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          Block& block = board.pixels.blocks[b];
                          memory.store(block, at, memory.load(block, at) ^ flip, mask_of(bits));
                      });
    });
}
void mem_and_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    combine_fields(board, range, o, [](auto p, auto q) PXPL5_BODY { return p & q; });
}
void mem_or_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    combine_fields(board, range, o, [](auto p, auto q) PXPL5_BODY { return p | q; });
}
void mem_xor_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    combine_fields(board, range, o, [](auto p, auto q) PXPL5_BODY { return p ^ q; });
}

void mem_lt_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    test_fields(board, range, o, 0, IsLess());
}
void mem_lt_mem_s(Board& board, BlockRange range, Operands o, Coefficients) {
    test_fields(board, range, o, top_bit(o.n), IsLess());
}
void mem_eq_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    test_fields(board, range, o, 0, IsEqual());
}
void mem_eq_const(Board& board, BlockRange range, Operands o, Coefficients k) {
    test_constant(board, range, o, k, 0, IsEqual());
}
void mem_ge_const(Board& board, BlockRange range, Operands o, Coefficients k) {
    test_constant(board, range, o, k, 0, IsAtLeast());
}
void mem_lt_const(Board& board, BlockRange range, Operands o, Coefficients k) {
    test_constant(board, range, o, k, 0, IsLess());
}
void mem_ge_const_s(Board& board, BlockRange range, Operands o, Coefficients k) {
    test_constant(board, range, o, k, top_bit(o.n), IsAtLeast());
}
void mem_lt_const_s(Board& board, BlockRange range, Operands o, Coefficients k) {
    test_constant(board, range, o, k, top_bit(o.n), IsLess());
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
