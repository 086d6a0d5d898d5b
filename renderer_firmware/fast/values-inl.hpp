// Arithmetic on vectors of numbers: the only definition of sums, products, quotients, roots and
// comparisons, for handlers and fused programs.
// Included behind hwy/foreach_target.h, which requires the toggling include guard.
#if defined(PXPL5_FAST_VALUES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PXPL5_FAST_VALUES_INL
#undef PXPL5_FAST_VALUES_INL
#else
#define PXPL5_FAST_VALUES_INL
#endif

#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

// ---- comparison

struct IsLess {
    template <typename N>
    HWY_INLINE M operator()(N p, N q) const {
        return less(p, q);
    }
};
struct IsAtLeast {
    template <typename N>
    HWY_INLINE M operator()(N p, N q) const {
        return hn::Not(less(p, q));
    }
};
struct IsEqual {
    template <typename N>
    HWY_INLINE M operator()(N p, N q) const {
        return equal(p, q);
    }
};

// ---- addition

/// A sum or difference of n bits, and its carry, borrow or saturation bit.
template <typename N>
struct Sum {
    N value;
    M carry;
};

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

// ---- multiplication

/// Returns the n-bit number `value`, sign-extended to the lane.
HWY_INLINE V sign_extended(V value, std::uint32_t n) {
    const V sign = splat(top_bit(n));
    return hn::Sub(hn::Xor(value, sign), sign);
}

/// Returns the product of unsigned 32-bit lanes.
HWY_INLINE Wide product(V p, V q) {
    const hn::RepartitionToWide<D> d64;
    const auto even = hn::BitCast(D(), hn::MulEven(p, q));
    const auto odd =
        hn::BitCast(D(), hn::MulEven(hn::BitCast(D(), hn::ShiftRight<32>(hn::BitCast(d64, p))),
                                     hn::BitCast(D(), hn::ShiftRight<32>(hn::BitCast(d64, q)))));
    const V lo = hn::Mul(p, q);
    const V hi = hn::OddEven(odd, hn::BitCast(D(), hn::ShiftRight<32>(hn::BitCast(d64, even))));
    return {lo, hi};
}

/// Returns the product of the signed lower halves of lanes; the upper halves of `q` are 0.
HWY_INLINE V half_product(V p, V q) {
    const hn::RepartitionToNarrow<DI> half;
    auto unused = hn::Zero(DI());
    return hn::BitCast(
        D(), hn::ReorderWidenMulAccumulate(DI(), hn::BitCast(half, p), hn::BitCast(half, q),
                                           hn::Zero(DI()), unused));
}

/// Returns the product of signed 32-bit lanes.
HWY_INLINE Wide signed_product(V p, V q) {
    const Wide w = product(p, q);
    const V sign_p = hn::BitCast(D(), hn::ShiftRight<31>(hn::BitCast(DI(), p)));
    const V sign_q = hn::BitCast(D(), hn::ShiftRight<31>(hn::BitCast(DI(), q)));
    return {w.lo, hn::Sub(hn::Sub(w.hi, hn::And(sign_p, q)), hn::And(sign_q, p))};
}

// ---- division and square root, through correctly rounded floating point
//
// floor() of the rounded result is exact. A quotient p/q that is not an integer is at least 1/q
// below the next integer k; relative to k that is 1/(kq), and kq < p + q. With p < 2^23 this is
// more than half a step of a float; with p < 2^32 it is far more than one step of a double.
// sqrt(k^2 - 1) is 1/(2k) below k: with k <= 2^11.5 more than half a step of a float, with k <=
// 2^16 of a double.

inline constexpr std::uint32_t max_float_bits = 23;

using DF = hn::RebindToFloat<D>;
using D64 = hn::RepartitionToWide<D>;
using DD = hn::RebindToFloat<D64>;

/// Returns floor(f(p, q)) on 32-bit lanes below 2^23.
template <typename F>
HWY_INLINE V floor_in_floats(V p, V q, const F& f) {
    const auto p_float = hn::ConvertTo(DF(), hn::BitCast(DI(), p));
    const auto q_float = hn::ConvertTo(DF(), hn::BitCast(DI(), q));
    return hn::BitCast(D(), hn::ConvertTo(DI(), f(p_float, q_float)));
}

/// Returns floor(f(p, q)) on 64-bit lanes below 2^32.
template <typename F>
HWY_INLINE hn::Vec<D64> floor_in_doubles(hn::Vec<D64> p, hn::Vec<D64> q, const F& f) {
    // 2^52 + p has the bits of p as its mantissa. Also used in reverse.
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

/// Returns floor(p / q) on n bits; all ones where q is 0.
HWY_INLINE Narrow quotient(Narrow p, Narrow q, std::uint32_t n) {
    const M is_zero = equal(q, number<Narrow>(0));
    const V safe = hn::IfThenElse(is_zero, splat(1), q.lo);
    const V result =
        floor_exact(p.lo, safe, n, [](auto v, auto w) PXPL5_BODY { return hn::Div(v, w); });
    return choose(is_zero, number<Narrow>(ones(n)), {result});
}

/// Returns floor(sqrt(p)) on n bits.
HWY_INLINE Narrow root(Narrow p, std::uint32_t n) {
    return {floor_exact(p.lo, p.lo, n, [](auto v, auto) PXPL5_BODY { return hn::Sqrt(v); })};
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PXPL5_FAST_VALUES_INL
