// Group arithmetic, fast: addition, multiplication, division and square roots of fields.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/arithmetic.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/values-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

// ---- addition

/// m[a] = sum(m[a], m[b], the low n bits set). Also sets the carry bits.
template <typename Add>
HWY_INLINE void add_fields(Board& board, BlockRange range, Operands o, const Add& sum) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> to(o.a, o.n), from(o.b, o.n);
        const N low = number<N>(ones(o.n));
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          Block& block = board.pixels.blocks[b];
                          const Sum<N> s = sum(to.load(block, at), from.load(block, at), low);
                          to.store(block, at, s.value, mask_of(bits));
                          set_carry(board, b, at, bits, s.carry);
                      });
    });
}

void mem_plus_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    add_fields(board, range, o, Plus());
}
void mem_minus_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    add_fields(board, range, o, Minus());
}
void mem_satplus_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    add_fields(board, range, o, HeldPlus());
}
void mem_satminus_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    add_fields(board, range, o, HeldMinus());
}
void mem_plus_const(Board& board, BlockRange range, Operands o, Coefficients k) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> to(o.a, o.n);
        const N low = number<N>(ones(o.n));
        const N added = number<N>(static_cast<std::uint64_t>(std::int64_t{k[0]})) & low;
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          Block& block = board.pixels.blocks[b];
                          const Sum<N> s = Plus()(to.load(block, at), added, low);
                          to.store(block, at, s.value, mask_of(bits));
                          set_carry(board, b, at, bits, s.carry);
                      });
    });
}

/// Negates m[a] if `always`, else where the sign bit of m[a] is set.
HWY_INLINE void negate(Board& board, BlockRange range, Operands o, bool always) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> memory(o.a, o.n);
        const N zero = number<N>(0), sign = number<N>(always ? 0 : top_bit(o.n));
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          Block& block = board.pixels.blocks[b];
                          const N value = memory.load(block, at);
                          // With sign 0 no pixel is kept: value & 0 is never unequal to 0.
                          const M keep = always ? mask_of(0) : hn::Not(is_set(value, sign));
                          memory.store(block, at, choose(keep, value, zero - value), mask_of(bits));
                      });
    });
}
void neg_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    negate(board, range, o, true);
}
void abs_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    negate(board, range, o, false);
}

// ---- multiplication

/// m[a : a+2n) = left(block, at) * right(block, at); both factors have n bits.
template <typename Left, typename Right>
HWY_INLINE void multiply(Board& board, BlockRange range, Operands o, bool is_signed,
                         const Left& left, const Right& right) {
    const auto extend = [&](V v) PXPL5_BODY { return is_signed ? sign_extended(v, o.n) : v; };
    if (o.n <= 16) {
        const Field<Narrow> to(o.a, 2 * o.n);
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          Block& block = board.pixels.blocks[b];
                          const V p = extend(left(block, at)), q = extend(right(block, at));
                          to.store(block, at, {hn::Mul(p, q)}, mask_of(bits));
                      });
        return;
    }
    const Field<Wide> to(o.a, 2 * o.n);
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        Block& block = board.pixels.blocks[b];
        const V p = extend(left(block, at)), q = extend(right(block, at));
        to.store(block, at, is_signed ? signed_product(p, q) : product(p, q), mask_of(bits));
    });
}

HWY_INLINE void multiply_fields(Board& board, BlockRange range, Operands o, bool is_signed) {
    const Field<Narrow> p(o.a, o.n), q(o.b, o.n);
    multiply(
        board, range, o, is_signed,
        [&](const Block& block, std::size_t at) PXPL5_BODY { return p.load(block, at).lo; },
        [&](const Block& block, std::size_t at) PXPL5_BODY { return q.load(block, at).lo; });
}
void mul_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    multiply_fields(board, range, o, false);
}
void mul_mem_s(Board& board, BlockRange range, Operands o, Coefficients) {
    multiply_fields(board, range, o, true);
}
void mul_const(Board& board, BlockRange range, Operands o, Coefficients k) {
    const Field<Narrow> p(o.b, o.n);
    const V q = splat(static_cast<std::uint32_t>(k[0]) & ones(o.n));
    multiply(
        board, range, o, true,
        [&](const Block& block, std::size_t at) PXPL5_BODY { return p.load(block, at).lo; },
        [&](const Block&, std::size_t) PXPL5_BODY { return q; });
}

// ---- division and square root

void div_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    const Field<Narrow> to(o.a, o.n), by(o.b, o.n);
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        Block& block = board.pixels.blocks[b];
        to.store(block, at, quotient(to.load(block, at), by.load(block, at), o.n), mask_of(bits));
    });
}

void sqrt_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    const Field<Narrow> memory(o.a, o.n);
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        Block& block = board.pixels.blocks[b];
        memory.store(block, at, root(memory.load(block, at), o.n), mask_of(bits));
    });
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
