// Group arithmetic, fast: adding, multiplying, dividing and square roots of fields.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/arithmetic.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles what follows once per target.
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

// ---- addition

/// A sum or difference of n bits and its carry, borrow or "was held" bit.
template <typename N>
struct Sum {
    N value;
    M carry;
};

/// m[a] = sum(m[a], m[b], the low n bits set), and the carry bits.
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

struct Plus {
    template <typename N>
    HWY_INLINE Sum<N> operator()(N p, N q, N low) const {
        const N sum = (p + q) & low;
        return {sum, less(sum, p)};
    }
};
struct Minus {
    template <typename N>
    HWY_INLINE Sum<N> operator()(N p, N q, N low) const {
        return {(p - q) & low, less(p, q)};
    }
};
struct HeldPlus {
    template <typename N>
    HWY_INLINE Sum<N> operator()(N p, N q, N low) const {
        const Sum<N> s = Plus()(p, q, low);
        return {choose(s.carry, low, s.value), s.carry};
    }
};
struct HeldMinus {
    template <typename N>
    HWY_INLINE Sum<N> operator()(N p, N q, N low) const {
        const Sum<N> s = Minus()(p, q, low);
        return {choose(s.carry, number<N>(0), s.value), s.carry};
    }
};

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

/// Negates m[a] where `always`, else where its sign bit is set.
HWY_INLINE void negate(Board& board, BlockRange range, Operands o, bool always) {
    by_width(o.n, [&](auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> memory(o.a, o.n);
        const N zero = number<N>(0), sign = number<N>(always ? 0 : top_bit(o.n));
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          Block& block = board.pixels.blocks[b];
                          const N value = memory.load(block, at);
                          // With sign 0 nothing is kept: value & 0 is never unequal to 0.
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

/// The n-bit number `value` with its sign in all bits above.
HWY_INLINE V sign_extended(V value, std::uint32_t n) {
    const V sign = splat(top_bit(n));
    return hn::Sub(hn::Xor(value, sign), sign);
}

/// Product of unsigned 32-bit lanes.
HWY_INLINE Wide product(V p, V q) {
    const hn::RepartitionToWide<D> d64;
    const auto even = hn::BitCast(D(), hn::MulEven(p, q));
    const auto odd =
        hn::BitCast(D(), hn::MulEven(hn::BitCast(D(), hn::ShiftRight<32>(hn::BitCast(d64, p))),
                                     hn::BitCast(D(), hn::ShiftRight<32>(hn::BitCast(d64, q)))));
    const V lo = hn::OddEven(hn::BitCast(D(), hn::ShiftLeft<32>(hn::BitCast(d64, odd))), even);
    const V hi = hn::OddEven(odd, hn::BitCast(D(), hn::ShiftRight<32>(hn::BitCast(d64, even))));
    return {lo, hi};
}

/// Product of signed 32-bit lanes.
HWY_INLINE Wide signed_product(V p, V q) {
    const Wide w = product(p, q);
    const V sign_p = hn::BitCast(D(), hn::ShiftRight<31>(hn::BitCast(DI(), p)));
    const V sign_q = hn::BitCast(D(), hn::ShiftRight<31>(hn::BitCast(DI(), q)));
    return {w.lo, hn::Sub(hn::Sub(w.hi, hn::And(sign_p, q)), hn::And(sign_q, p))};
}

/// m[a : a+2n) = left(block, at) * right(block, at), n-bit numbers.
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

// ---- division and square root, through correctly rounded floating point
//
// floor() of the rounded result is exact: a quotient p/q that is no integer lies at least 1/q
// below the next integer k, that is, by at least 1/(kq) of it; kq < p + q. With p < 2^23 that is
// more than half a step of a float, with p < 2^32 far more than one of a double. sqrt(k^2 - 1)
// lies 1/(2k) below k: with k <= 2^11.5 more than half a step of a float, with k <= 2^16 of a
// double.

inline constexpr std::uint32_t max_float_bits = 23;

using DF = hn::RebindToFloat<D>;
using D64 = hn::RepartitionToWide<D>;
using DD = hn::RebindToFloat<D64>;

/// floor(f(p, q)) on 32-bit lanes below 2^23.
template <typename F>
HWY_INLINE V floor_in_floats(V p, V q, const F& f) {
    const auto p_float = hn::ConvertTo(DF(), hn::BitCast(DI(), p));
    const auto q_float = hn::ConvertTo(DF(), hn::BitCast(DI(), q));
    return hn::BitCast(D(), hn::ConvertTo(DI(), f(p_float, q_float)));
}

/// floor(f(p, q)) on 64-bit lanes below 2^32.
template <typename F>
HWY_INLINE hn::Vec<D64> floor_in_doubles(hn::Vec<D64> p, hn::Vec<D64> q, const F& f) {
    // 2^52 + p has the bits of p as its mantissa, and back.
    const auto two_52 = hn::Set(DD(), 4503599627370496.0);
    const auto bits = hn::BitCast(D64(), two_52);
    const auto p_double = hn::Sub(hn::BitCast(DD(), hn::Or(p, bits)), two_52);
    const auto q_double = hn::Sub(hn::BitCast(DD(), hn::Or(q, bits)), two_52);
    const auto result = hn::Add(hn::Floor(f(p_double, q_double)), two_52);
    return hn::Xor(hn::BitCast(D64(), result), bits);
}

template <typename F>
HWY_INLINE V floor_exact(V p, V q, std::uint32_t n, const F& f) {
    if (n <= max_float_bits) {
        return floor_in_floats(p, q, f);
    }
    const D64 d64;
    const auto low = hn::Set(d64, 0xFFFFFFFFU);
    const auto p64 = hn::BitCast(d64, p), q64 = hn::BitCast(d64, q);
    const auto even = floor_in_doubles(hn::And(p64, low), hn::And(q64, low), f);
    const auto odd = floor_in_doubles(hn::ShiftRight<32>(p64), hn::ShiftRight<32>(q64), f);
    return hn::BitCast(D(), hn::Or(even, hn::ShiftLeft<32>(odd)));
}

void div_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    const Field<Narrow> to(o.a, o.n), by(o.b, o.n);
    const Narrow low = number<Narrow>(ones(o.n)), zero = number<Narrow>(0);
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        Block& block = board.pixels.blocks[b];
        const Narrow q = by.load(block, at);
        const M is_zero = equal(q, zero);
        const V safe = hn::IfThenElse(is_zero, splat(1), q.lo);
        const Narrow result = {floor_exact(to.load(block, at).lo, safe, o.n,
                                           [](auto p, auto d)
                                               PXPL5_BODY { return hn::Div(p, d); })};
        to.store(block, at, choose(is_zero, low, result), mask_of(bits));
    });
}

void sqrt_mem(Board& board, BlockRange range, Operands o, Coefficients) {
    const Field<Narrow> memory(o.a, o.n);
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        Block& block = board.pixels.blocks[b];
        const V p = memory.load(block, at).lo;
        const Narrow root = {
            floor_exact(p, p, o.n, [](auto v, auto) PXPL5_BODY { return hn::Sqrt(v); })};
        memory.store(block, at, root, mask_of(bits));
    });
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
