// Instructions with operands that are known at compile time, on pixels in registers. The compiler
// knows the position of each field, so a handler's masks, shifts and memory accesses become one or
// two processor instructions, or none.
// Included behind hwy/foreach_target.h, which requires the toggling include guard.
#if defined(PXPL5_FAST_FUSED_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PXPL5_FAST_FUSED_INL
#undef PXPL5_FAST_FUSED_INL
#else
#define PXPL5_FAST_FUSED_INL
#endif

#include <type_traits>

#include "renderer_firmware/fast/values-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

/// A vector of pixels, in registers. Before commit(), written columns are valid only in enabled
/// pixels. No code reads the others before the enables change.
struct Pixels {
    V columns[hal::column_count];
    V kept[hal::column_count];  ///< Values at the last commit().
    M enable, carry;

    template <std::size_t k>
    HWY_INLINE void commit() {
        columns[k] = kept[k] = hn::IfThenElse(enable, columns[k], kept[k]);
    }
};

template <std::uint32_t bits>
HWY_INLINE V shifted_right(V v) {
    if constexpr (bits == 0) {
        return v;
    } else {
        return hn::ShiftRight<bits>(v);
    }
}
template <std::uint32_t bits>
HWY_INLINE V shifted_left(V v) {
    if constexpr (bits == 0) {
        return v;
    } else {
        return hn::ShiftLeft<bits>(v);
    }
}

/// Returns the bits of `yes` where `mask` is set, else the bits of `no`.
HWY_INLINE V select_bits(V mask, V yes, V no) {
    if constexpr (lanes == 16) {
        return hn::IfVecThenElse(mask, yes, no);  // Narrower targets select bytes.
    } else {
        return hn::Or(hn::And(mask, yes), hn::AndNot(mask, no));
    }
}

/// Field m[a : a+n) of Pixels.
template <std::uint32_t a, std::uint32_t n>
class FixedField {
  public:
    static_assert(n >= 1 && n <= 64 && a + n <= isa::memory_bits);
    using Number = std::conditional_t<(n <= 32), Narrow, Wide>;

    static HWY_INLINE Number load(const Pixels& p) {
        if constexpr (n <= 32) {
            return {part<0>(p)};
        } else {
            return {part<0>(p), part<1>(p)};
        }
    }

    /// Returns the field with undefined bits above it; n is at most 32.
    static HWY_INLINE V load_low(const Pixels& p) {
        return end <= 32 ? shifted_right<shift>(p.columns[first]) : part<0>(p);
    }

    /// Stores the bits of `column` at the position of the field, which lies in one column.
    static HWY_INLINE void put_moved(Pixels& p, V column) {
        static_assert(end <= 32);
        put<0>(p, column);
    }

    /// Stores the low n bits of `value` in the enabled pixels.
    static HWY_INLINE void store(Pixels& p, Number value) {
        put<0>(p, shifted_left<shift>(value.lo));
        if constexpr (end > 32) {
            V next = shift == 0 ? hn::Zero(D()) : shifted_right<(32 - shift) % 32>(value.lo);
            if constexpr (n > 32) {
                next = hn::Or(next, shifted_left<shift>(value.hi));
            }
            put<1>(p, next);
        }
        if constexpr (end > 64) {
            put<2>(p, shifted_right<32 - shift>(value.hi));
        }
    }

  private:
    static constexpr std::uint32_t first = a / 32, shift = a % 32, end = shift + n;

    /// Returns the bits of the field from bit 32 k on.
    template <std::uint32_t k>
    static HWY_INLINE V part(const Pixels& p) {
        constexpr std::uint32_t left = n - 32 * k, count = left < 32 ? left : 32;
        V v = shifted_right<shift>(p.columns[first + k]);
        if constexpr (shift + count > 32) {
            v = hn::Or(v, shifted_left<32 - shift>(p.columns[first + k + 1]));
        }
        return shift + count == 32 || count == 32 ? v : hn::And(v, splat(ones(count)));
    }

    /// Stores the bits of `value` that belong to the field in column first + k.
    template <std::uint32_t k>
    static HWY_INLINE void put(Pixels& p, V value) {
        constexpr std::uint32_t low = k == 0 ? shift : 0, high = end < 32 * (k + 1) ? end % 32 : 32;
        constexpr auto changed = static_cast<std::uint32_t>(ones(high) & ~std::uint64_t{0} << low);
        V& column = p.columns[first + k];
        if constexpr (changed != 0xFFFFFFFF) {
            value = select_bits(splat(changed), value, column);
        }
        column = value;
    }
};

/// Fields m[a : a+n) and m[b : b+n) of an instruction.
template <isa::Operands o>
using FieldA = FixedField<o.a, o.n>;
template <isa::Operands o>
using FieldB = FixedField<o.b, o.n>;

/// Returns the low n bits of K as a number of the field's width.
template <std::uint32_t n>
HWY_INLINE auto constant(std::int32_t k) {
    using Number = typename FixedField<0, n>::Number;
    return number<Number>(static_cast<std::uint64_t>(std::int64_t{k}) & ones(n));
}

HWY_INLINE void keep(Pixels& p, M mask) {
    p.enable = hn::And(p.enable, mask);
}
HWY_INLINE void set_carry(Pixels& p, M carry) {
    p.carry = hn::Or(hn::AndNot(p.enable, p.carry), hn::And(p.enable, carry));
}

// ---- the rows that region programs use; K is 0 for rows without K

template <isa::Op op>
using Row = std::integral_constant<isa::Op, op>;

/// Returns the mask of the pixels where bit m[a] is 1.
template <std::uint32_t a>
HWY_INLINE M memory_bit(const Pixels& p) {
    return hn::TestBit(p.columns[a / 32], splat(1U << a % 32));
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::set_enabs>, Pixels& p, std::int32_t) {
    p.enable = mask_of(all_lanes);
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::enab_into_mem>, Pixels& p, std::int32_t) {
    constexpr std::uint32_t k = o.a / 32;
    const V bit = splat(1U << o.a % 32);
    p.columns[k] = p.kept[k] = select_bits(bit, hn::IfThenElseZero(p.enable, bit), p.columns[k]);
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mem_into_enab>, Pixels& p, std::int32_t) {
    p.enable = memory_bit<o.a>(p);
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::enab_and_mem>, Pixels& p, std::int32_t) {
    p.enable = hn::And(p.enable, memory_bit<o.a>(p));
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::enab_and_not_mem>, Pixels& p, std::int32_t) {
    p.enable = hn::AndNot(memory_bit<o.a>(p), p.enable);
}

template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mem_into_mem>, Pixels& p, std::int32_t) {
    constexpr std::uint32_t from = o.b % 32, to = o.a % 32;
    if constexpr (from + o.n <= 32 && to + o.n <= 32) {
        // The bits beside the field move too. put_moved() ignores them.
        const V column = p.columns[o.b / 32];
        FieldA<o>::put_moved(p, from < to ? shifted_left<(to - from) % 32>(column)
                                          : shifted_right<(from - to) % 32>(column));
    } else {
        FieldA<o>::store(p, FieldB<o>::load(p));
    }
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::const_into_mem>, Pixels& p, std::int32_t k) {
    FieldA<o>::store(p, constant<o.n>(k));
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::clear_mem>, Pixels& p, std::int32_t) {
    FieldA<o>::store(p, constant<o.n>(0));
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mem_eq_const>, Pixels& p, std::int32_t k) {
    keep(p, IsEqual()(FieldA<o>::load(p), constant<o.n>(k)));
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mem_ge_const>, Pixels& p, std::int32_t k) {
    keep(p, IsAtLeast()(FieldA<o>::load(p), constant<o.n>(k)));
}

/// m[a] = sum(m[a], m[b]). Also sets the carry.
template <Operands o, typename Add>
HWY_INLINE void add_fields(Pixels& p, const Add& add) {
    const auto sum = add(FieldA<o>::load(p), FieldB<o>::load(p), constant<o.n>(-1));
    FieldA<o>::store(p, sum.value);
    set_carry(p, sum.carry);
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mem_plus_mem>, Pixels& p, std::int32_t) {
    add_fields<o>(p, Plus());
}
/// HeldPlus for fewer than 32 bits.
struct HeldPlusInLane {
    HWY_INLINE Sum<Narrow> operator()(Narrow p, Narrow q, Narrow low) const {
        const V sum = hn::Add(p.lo, q.lo);
        return {{hn::Min(sum, low.lo)}, hn::Gt(sum, low.lo)};
    }
};
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mem_satplus_mem>, Pixels& p, std::int32_t) {
    static_assert(o.n < 32);
    if constexpr (o.a % 32 + o.n == 32) {
        // A field at the top of its column is added in place; its carry leaves the lane.
        V& column = p.columns[o.a / 32];
        const V sum = hn::Add(column, shifted_left<o.a % 32>(FieldB<o>::load_low(p)));
        const M carry = hn::Lt(sum, column);
        column = hn::IfThenElse(carry, hn::Or(sum, splat(ones(o.n) << o.a % 32)), sum);
        set_carry(p, carry);
    } else {
        add_fields<o>(p, HeldPlusInLane());
    }
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::neg_mem>, Pixels& p, std::int32_t) {
    FieldA<o>::store(p, constant<o.n>(0) - FieldA<o>::load(p));
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::not_mem>, Pixels& p, std::int32_t) {
    FieldA<o>::store(p, constant<o.n>(-1) - FieldA<o>::load(p));
}

/// m[a : a+2n) = m[a] * m[b].
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mul_mem>, Pixels& p, std::int32_t) {
    const V q = FieldA<o>::load(p).lo, r = FieldB<o>::load(p).lo;
    if constexpr (o.n <= 16) {
        FixedField<o.a, 2 * o.n>::store(p, {hn::Mul(q, r)});
    } else {
        FixedField<o.a, 2 * o.n>::store(p, product(q, r));
    }
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mul_mem_s>, Pixels& p, std::int32_t) {
    static_assert(o.n == 16);
    FixedField<o.a, 32>::store(p, {half_product(FieldA<o>::load_low(p), FieldB<o>::load(p).lo)});
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::mul_const>, Pixels& p, std::int32_t k) {
    static_assert(o.n == 16);
    FixedField<o.a, 32>::store(p, {half_product(FieldB<o>::load_low(p), constant<16>(k).lo)});
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::div_mem>, Pixels& p, std::int32_t) {
    FieldA<o>::store(p, quotient(FieldA<o>::load(p), FieldB<o>::load(p), o.n));
}
template <Operands o>
HWY_INLINE void run_row(Row<isa::Op::sqrt_mem>, Pixels& p, std::int32_t) {
    FieldA<o>::store(p, root(FieldA<o>::load(p), o.n));
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PXPL5_FAST_FUSED_INL
