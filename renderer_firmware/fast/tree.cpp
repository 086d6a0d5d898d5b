// Group tree, fast: linear and quadratic expressions in x and y.
//
// 32-bit lanes hold Q modulo 2^32, which suffices if all required bits are below bit 32. Otherwise
// two halves hold Q exactly. A sign test of a linear form first tests the corners of the block.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/tree.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

template <typename N>
HWY_INLINE N from_lanes(const std::int64_t* values) {
    HWY_ALIGN std::uint32_t lo[lanes], hi[lanes];
    for (std::size_t i = 0; i < lanes; ++i) {
        lo[i] = static_cast<std::uint32_t>(values[i]);
        hi[i] = static_cast<std::uint32_t>(static_cast<std::uint64_t>(values[i]) >> 32);
    }
    if constexpr (std::is_same_v<N, Wide>) {
        return {hn::Load(D(), lo), hn::Load(D(), hi)};
    } else {
        return {hn::Load(D(), lo)};
    }
}

/// A x + B y + C.
template <typename N>
class Linear {
  public:
    explicit HWY_INLINE Linear(Coefficients k) : a_(k[0]), b_(k[1]), c_(k[2]) {
        std::int64_t offsets[lanes];
        for (std::size_t i = 0; i < lanes; ++i) {
            offsets[i] = a_ * static_cast<std::int64_t>(i % hal::tile_side) +
                         b_ * static_cast<std::int64_t>(i / hal::tile_side);
        }
        offset_ = from_lanes<N>(offsets);
    }
    HWY_INLINE std::int64_t at_place(Corner p) const { return a_ * p.x + b_ * p.y + c_; }
    HWY_INLINE N at(Corner p) const {
        return number<N>(static_cast<std::uint64_t>(at_place(p))) + offset_;
    }

    /// Returns 1 or 0 if bit `bit` of the form has this value in the whole block, else -1.
    HWY_INLINE int bit_in_block(std::size_t block, std::uint32_t bit) const {
        const std::int64_t q = at_place(block_corner(block));
        const std::int64_t across = a_ * static_cast<std::int64_t>(hal::block_width - 1);
        const std::int64_t down = b_ * static_cast<std::int64_t>(hal::block_height - 1);
        const std::int64_t low = q + HWY_MIN(across, 0) + HWY_MIN(down, 0);
        const std::int64_t high = q + HWY_MAX(across, 0) + HWY_MAX(down, 0);
        return low >> bit == high >> bit ? static_cast<int>(low >> bit & 1) : -1;
    }

  private:
    std::int64_t a_, b_, c_;
    N offset_;
};

/// A x + B y + C + D x x + E x y + F y y.
template <typename N>
class Quadratic {
  public:
    explicit HWY_INLINE Quadratic(Coefficients k)
        : a_(k[0]), b_(k[1]), c_(k[2]), d_(k[3]), e_(k[4]), f_(k[5]) {}
    HWY_INLINE N at(Corner p) const {
        std::int64_t values[lanes];
        for (std::size_t i = 0; i < lanes; ++i) {
            const std::int64_t x = p.x + static_cast<std::int64_t>(i % hal::tile_side);
            const std::int64_t y = p.y + static_cast<std::int64_t>(i / hal::tile_side);
            values[i] = (d_ * x + e_ * y + a_) * x + (f_ * y + b_) * y + c_;
        }
        return from_lanes<N>(values);
    }
    HWY_INLINE int bit_in_block(std::size_t, std::uint32_t) const { return -1; }

  private:
    std::int64_t a_, b_, c_, d_, e_, f_;
};

/// Returns floor(q / 2^f) in the low bits that q determines.
HWY_INLINE Narrow shifted(Narrow q, std::uint32_t f) {
    return {hn::ShiftRightSame(q.lo, static_cast<int>(f))};
}
HWY_INLINE Wide shifted(Wide q, std::uint32_t f) {
    const auto signed_hi = hn::BitCast(DI(), q.hi);
    const V sign = hn::BitCast(D(), hn::ShiftRight<31>(signed_hi));
    const int s = static_cast<int>(f % 32);
    const V hi = hn::BitCast(D(), hn::ShiftRightSame(signed_hi, s));
    if (f >= 32) {
        return {hi, sign};
    }
    return {s == 0 ? q.lo : hn::Or(hn::ShiftRightSame(q.lo, s), hn::ShiftLeftSame(q.hi, 32 - s)),
            hi};
}

/// Calls body(form, As<N>) with the form of type Form<N> whose numbers contain bits f .. f+n-1.
template <template <typename> class Form, typename Body>
HWY_INLINE void with_form(std::uint32_t bits, Coefficients k, const Body& body) {
    if (bits <= 32) {
        body(Form<Narrow>(k), As<Narrow>());
    } else {
        body(Form<Wide>(k), As<Wide>());
    }
}

/// Keeps the pixels where bit n-1 of Q is `wanted`.
template <template <typename> class Form>
HWY_INLINE void sign_test(Board& board, BlockRange range, Operands o, Coefficients k, int wanted) {
    with_form<Form>(o.n, k, [&](const auto& form, auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const N sign = number<N>(top_bit(o.n));
        for (std::size_t b = range.first; b < range.end; ++b) {
            if (!board.pixels.is_occupied(b)) {
                continue;
            }
            const int bit = form.bit_in_block(b, o.n - 1);
            if (bit == wanted) {
                continue;
            }
            keep_where(board, {b, b + 1}, [&](std::size_t block, std::size_t at) PXPL5_BODY {
                if (bit >= 0) {
                    return mask_of(0);
                }
                const M set = is_set(form.at(corner(block, at)), sign);
                return wanted == 1 ? set : hn::Not(set);
            });
        }
    });
}

/// Keeps the pixels where the low n bits of T are less than m[a] (`below`), or not less.
template <template <typename> class Form>
HWY_INLINE void memory_test(Board& board, BlockRange range, Operands o, Coefficients k,
                            bool below) {
    with_form<Form>(o.b + o.n, k, [&](const auto& form, auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> memory(o.a, o.n);
        const N low = number<N>(ones(o.n));
        keep_where(board, range, [&](std::size_t b, std::size_t at) PXPL5_BODY {
            const N t = shifted(form.at(corner(b, at)), o.b) & low;
            const M lt = less(t, memory.load(board.pixels.blocks[b], at));
            return below ? lt : hn::Not(lt);
        });
    });
}

template <template <typename> class Form>
HWY_INLINE void store_form(Board& board, BlockRange range, Operands o, Coefficients k) {
    with_form<Form>(o.b + o.n, k, [&](const auto& form, auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> memory(o.a, o.n);
        where_enabled(board, range,
                      [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                          memory.store(board.pixels.blocks[b], at,
                                       shifted(form.at(corner(b, at)), o.b), mask_of(bits));
                      });
    });
}

template <template <typename> class Form>
HWY_INLINE void store_clamped(Board& board, BlockRange range, Operands o, Coefficients k) {
    const Form<Wide> form(k);
    const Field<Wide> memory(o.a, o.n);
    const Wide top = number<Wide>(ones(o.n)), zero = number<Wide>(0);
    const Wide sign = number<Wide>(top_bit(64));
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        const Wide t = shifted(form.at(corner(b, at)), o.b);
        const Wide held = choose(less(top, t), top, t);
        memory.store(board.pixels.blocks[b], at, choose(is_set(t, sign), zero, held),
                     mask_of(bits));
    });
}

/// m[a] += T or m[a] -= T. Also sets the carry to the carry or the borrow.
template <template <typename> class Form>
HWY_INLINE void add_form(Board& board, BlockRange range, Operands o, Coefficients k,
                         bool subtract) {
    with_form<Form>(o.b + o.n, k, [&](const auto& form, auto as) PXPL5_BODY {
        using N = typename decltype(as)::Number;
        const Field<N> memory(o.a, o.n);
        const N low = number<N>(ones(o.n));
        where_enabled(
            board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
                const N t = shifted(form.at(corner(b, at)), o.b) & low;
                const N old = memory.load(board.pixels.blocks[b], at);
                const N result = (subtract ? old - t : old + t) & low;
                memory.store(board.pixels.blocks[b], at, result, mask_of(bits));
                set_carry(board, b, at, bits, subtract ? less(old, t) : less(result, old));
            });
    });
}

void tree_ge_zero(Board& board, BlockRange range, Operands o, Coefficients k) {
    sign_test<Linear>(board, range, o, k, 0);
}
void tree_lt_zero(Board& board, BlockRange range, Operands o, Coefficients k) {
    sign_test<Linear>(board, range, o, k, 1);
}
void tree_lt_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    memory_test<Linear>(board, range, o, k, true);
}
void tree_ge_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    memory_test<Linear>(board, range, o, k, false);
}
void tree_into_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    store_form<Linear>(board, range, o, k);
}
void tree_clamp_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    store_clamped<Linear>(board, range, o, k);
}
void mem_plus_tree(Board& board, BlockRange range, Operands o, Coefficients k) {
    add_form<Linear>(board, range, o, k, false);
}
void mem_minus_tree(Board& board, BlockRange range, Operands o, Coefficients k) {
    add_form<Linear>(board, range, o, k, true);
}

void quad_ge_zero(Board& board, BlockRange range, Operands o, Coefficients k) {
    sign_test<Quadratic>(board, range, o, k, 0);
}
void quad_lt_zero(Board& board, BlockRange range, Operands o, Coefficients k) {
    sign_test<Quadratic>(board, range, o, k, 1);
}
void quad_lt_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    memory_test<Quadratic>(board, range, o, k, true);
}
void quad_ge_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    memory_test<Quadratic>(board, range, o, k, false);
}
void quad_into_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    store_form<Quadratic>(board, range, o, k);
}
void quad_clamp_mem(Board& board, BlockRange range, Operands o, Coefficients k) {
    store_clamped<Quadratic>(board, range, o, k);
}
void mem_plus_quad(Board& board, BlockRange range, Operands o, Coefficients k) {
    add_form<Quadratic>(board, range, o, k, false);
}
void mem_minus_quad(Board& board, BlockRange range, Operands o, Coefficients k) {
    add_form<Quadratic>(board, range, o, k, true);
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
