// Vectors of pixels, compiled once per vector target: enables as masks, fields as numbers.
// Included by every handler file behind hwy/foreach_target.h, hence the toggling include guard.
#if defined(PXPL5_FAST_VECTOR_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PXPL5_FAST_VECTOR_INL
#undef PXPL5_FAST_VECTOR_INL
#else
#define PXPL5_FAST_VECTOR_INL
#endif

#include <hwy/highway.h>

#include <bit>
#include <cassert>
#include <cstring>

#include "renderer_firmware/fast/handlers.hpp"

// Use this between the parameters and the body of a lambda that a loop calls for every vector. A
// call that is not inlined costs more than the work.
#undef PXPL5_BODY
#define PXPL5_BODY HWY_ATTR __attribute__((always_inline))

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using hal::Block, hal::Board, hal::PixelArray;
using isa::Coefficients, isa::Operands;

// A vector is a part of a tile: 4 x 4, 4 x 2 or 4 x 1 pixels.
inline constexpr std::size_t lanes =
    HWY_LANES(std::uint32_t) < hal::tile_pixels ? HWY_LANES(std::uint32_t) : hal::tile_pixels;
inline constexpr std::size_t lane_rows = lanes / hal::tile_side;
inline constexpr std::uint32_t all_lanes = (1U << lanes) - 1;
using D = hn::FixedTag<std::uint32_t, lanes>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

HWY_INLINE V splat(std::uint64_t value) {
    return hn::Set(D(), static_cast<std::uint32_t>(value));
}

/// Lane i has the column, 0..3, and the row of its pixel in the vector.
HWY_INLINE V lane_x() {
    return hn::And(hn::Iota(D(), 0), splat(3));
}
HWY_INLINE V lane_y() {
    return hn::ShiftRight<2>(hn::Iota(D(), 0));
}

/// Returns the position of the vector that starts `at` pixels into `block`.
struct Corner {
    std::int64_t x, y;
};
HWY_INLINE Corner block_corner(std::size_t block) {
    return {static_cast<std::int64_t>(block % hal::blocks_across * hal::block_width),
            static_cast<std::int64_t>(block / hal::blocks_across * hal::block_height)};
}
HWY_INLINE Corner corner(std::size_t block, std::size_t at) {
    const Corner b = block_corner(block);
    const std::size_t tile = at / hal::tile_pixels;
    return {b.x + static_cast<std::int64_t>(tile % 4 * hal::tile_side),
            b.y + static_cast<std::int64_t>(tile / 4 * hal::tile_side +
                                            at % hal::tile_pixels / hal::tile_side)};
}

// ---- masks and bits

// Bit i of a number, of Highway's mask bytes and of PixelBits is lane i: all are little-endian.
static_assert(std::endian::native == std::endian::little);

HWY_INLINE M mask_of(std::uint32_t bits) {
    std::uint8_t bytes[8];
    std::memcpy(bytes, &bits, sizeof bits);
    return hn::LoadMaskBits(D(), bytes);
}
HWY_INLINE std::uint32_t bits_of(M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(D(), mask, bytes);
    std::uint16_t bits = 0;
    std::memcpy(&bits, bytes, sizeof bits);
    return bits & all_lanes;
}

/// Returns the bits of the vector that starts at stored pixel `index`.
HWY_INLINE std::uint32_t load_bits(const hal::PixelBits& bits, std::size_t index) {
    if constexpr (lanes == 16) {
        std::uint16_t value = 0;
        std::memcpy(&value, &bits[index / 8], sizeof value);
        return value;
    } else {
        return bits[index / 8] >> index % 8 & all_lanes;
    }
}
HWY_INLINE void store_bits(hal::PixelBits& bits, std::size_t index, std::uint32_t value) {
    if constexpr (lanes == 16) {
        const auto stored = static_cast<std::uint16_t>(value);
        std::memcpy(&bits[index / 8], &stored, sizeof stored);
    } else if constexpr (lanes == 8) {
        bits[index / 8] = static_cast<std::uint8_t>(value);
    } else {
        const std::uint32_t kept = bits[index / 8] & ~(all_lanes << index % 8);
        bits[index / 8] = static_cast<std::uint8_t>(kept | value << index % 8);
    }
}

// ---- numbers: per lane 32 bits, or 64 as two halves

struct Narrow {
    V lo;
};
struct Wide {
    V lo, hi;
};

template <typename N>
HWY_INLINE N number(std::uint64_t value) {
    if constexpr (std::is_same_v<N, Wide>) {
        return {splat(value), splat(value >> 32)};
    } else {
        return {splat(value)};
    }
}

/// Returns the bits of a mask as a vector of ones (1) and zeros.
HWY_INLINE V one_where(M mask) {
    return hn::IfThenElseZero(mask, splat(1));
}

HWY_INLINE Narrow operator+(Narrow p, Narrow q) {
    return {hn::Add(p.lo, q.lo)};
}
HWY_INLINE Wide operator+(Wide p, Wide q) {
    const V lo = hn::Add(p.lo, q.lo);
    return {lo, hn::Add(hn::Add(p.hi, q.hi), one_where(hn::Lt(lo, p.lo)))};
}
HWY_INLINE Narrow operator-(Narrow p, Narrow q) {
    return {hn::Sub(p.lo, q.lo)};
}
HWY_INLINE Wide operator-(Wide p, Wide q) {
    return {hn::Sub(p.lo, q.lo), hn::Sub(hn::Sub(p.hi, q.hi), one_where(hn::Lt(p.lo, q.lo)))};
}
HWY_INLINE Narrow operator&(Narrow p, Narrow q) {
    return {hn::And(p.lo, q.lo)};
}
HWY_INLINE Wide operator&(Wide p, Wide q) {
    return {hn::And(p.lo, q.lo), hn::And(p.hi, q.hi)};
}
HWY_INLINE Narrow operator|(Narrow p, Narrow q) {
    return {hn::Or(p.lo, q.lo)};
}
HWY_INLINE Wide operator|(Wide p, Wide q) {
    return {hn::Or(p.lo, q.lo), hn::Or(p.hi, q.hi)};
}
HWY_INLINE Narrow operator^(Narrow p, Narrow q) {
    return {hn::Xor(p.lo, q.lo)};
}
HWY_INLINE Wide operator^(Wide p, Wide q) {
    return {hn::Xor(p.lo, q.lo), hn::Xor(p.hi, q.hi)};
}

/// Unsigned p < q.
HWY_INLINE M less(Narrow p, Narrow q) {
    return hn::Lt(p.lo, q.lo);
}
HWY_INLINE M less(Wide p, Wide q) {
    return hn::Or(hn::Lt(p.hi, q.hi), hn::And(hn::Eq(p.hi, q.hi), hn::Lt(p.lo, q.lo)));
}
HWY_INLINE M equal(Narrow p, Narrow q) {
    return hn::Eq(p.lo, q.lo);
}
HWY_INLINE M equal(Wide p, Wide q) {
    return hn::And(hn::Eq(p.lo, q.lo), hn::Eq(p.hi, q.hi));
}
template <typename N>
HWY_INLINE M is_set(N p, N bit) {
    return hn::Not(equal(p & bit, number<N>(0)));
}
HWY_INLINE Narrow choose(M mask, Narrow yes, Narrow no) {
    return {hn::IfThenElse(mask, yes.lo, no.lo)};
}
HWY_INLINE Wide choose(M mask, Wide yes, Wide no) {
    return {hn::IfThenElse(mask, yes.lo, no.lo), hn::IfThenElse(mask, yes.hi, no.hi)};
}

/// Returns a number with the low n bits set, n 1..64.
constexpr std::uint64_t ones(std::uint32_t n) {
    return ~std::uint64_t{0} >> (64 - n);
}
constexpr std::uint64_t top_bit(std::uint32_t n) {
    return std::uint64_t{1} << (n - 1);
}

// ---- fields

/// Field m[a : a+n) of vectors of pixels; n is 1..32 for Narrow, 1..64 for Wide.
template <typename N>
class Field {
  public:
    HWY_INLINE Field(std::uint32_t a, std::uint32_t n)
        : first_(a / 32), shift_(static_cast<int>(a % 32)), mask_(ones(n)), end_(a % 32 + n) {
        assert(n >= 1 && n <= (std::is_same_v<N, Wide> ? 64U : 32U) && a + n <= isa::memory_bits);
    }

    HWY_INLINE N load(const Block& block, std::size_t at) const {
        N value{};
        value.lo = low_part(column(block, 0, at));
        if (end_ > 32) {
            const V next = column(block, 1, at);
            value.lo = with_high_part(value.lo, next);
            if constexpr (std::is_same_v<N, Wide>) {
                value.hi = low_part(next);
                if (end_ > 64) {
                    value.hi = with_high_part(value.hi, column(block, 2, at));
                }
            }
        } else if constexpr (std::is_same_v<N, Wide>) {
            value.hi = hn::Zero(D());
        }
        return value & number<N>(mask_);
    }

    /// Stores the low n bits of `value` where `mask` is set.
    HWY_INLINE void store(Block& block, std::size_t at, N value, M mask) const {
        value = value & number<N>(mask_);
        put(block, 0, at, mask_ << shift_, hn::ShiftLeftSame(value.lo, shift_), mask);
        if (end_ <= 32) {
            return;
        }
        V part = shift_ == 0 ? hn::Zero(D()) : hn::ShiftRightSame(value.lo, 32 - shift_);
        if constexpr (std::is_same_v<N, Wide>) {
            part = hn::Or(part, hn::ShiftLeftSame(value.hi, shift_));
            if (end_ > 64) {
                put(block, 2, at, mask_ >> (64 - shift_), hn::ShiftRightSame(value.hi, 32 - shift_),
                    mask);
            }
        }
        put(block, 1, at, shift_ == 0 ? mask_ >> 32 : mask_ >> (32 - shift_), part, mask);
    }

  private:
    HWY_INLINE V column(const Block& block, std::size_t k, std::size_t at) const {
        return hn::Load(D(), &block.columns[first_ + k][at]);
    }
    HWY_INLINE V low_part(V word) const { return hn::ShiftRightSame(word, shift_); }
    HWY_INLINE V with_high_part(V low, V word) const {
        return shift_ == 0 ? low : hn::Or(low, hn::ShiftLeftSame(word, 32 - shift_));
    }
    HWY_INLINE void put(Block& block, std::size_t k, std::size_t at, std::uint64_t changed, V value,
                        M mask) const {
        std::uint32_t* word = &block.columns[first_ + k][at];
        const V old = hn::Load(D(), word);
        const V next = hn::Or(hn::AndNot(splat(changed), old), value);
        hn::Store(hn::IfThenElse(mask, next, old), D(), word);
    }

    std::size_t first_;
    int shift_;
    std::uint64_t mask_;
    std::uint32_t
        end_;  ///< Distance in bits from the start of the first column to the end of the field.
};

// ---- loops over pixels

/// Calls body(block number, at) -> M for every vector with an enabled pixel. The pixels of the
/// returned mask stay enabled.
template <typename Body>
HWY_INLINE void keep_where(Board& board, BlockRange range, const Body& body) {
    PixelArray& pixels = board.pixels;
    for (std::size_t b = range.first; b < range.end; ++b) {
        if (!pixels.is_occupied(b)) {
            continue;
        }
        std::uint32_t any = 0;
        for (std::size_t at = 0; at < hal::block_pixels; at += lanes) {
            const std::size_t index = b * hal::block_pixels + at;
            if (const std::uint32_t bits = load_bits(pixels.enable, index)) {
                const std::uint32_t kept = bits & bits_of(body(b, at));
                store_bits(pixels.enable, index, kept);
                any |= kept;
            }
        }
        pixels.set_occupied(b, any != 0);
    }
}

/// Calls body(block number, at, enabled bits) for every vector with an enabled pixel.
template <typename Body>
HWY_INLINE void where_enabled(Board& board, BlockRange range, const Body& body) {
    const PixelArray& pixels = board.pixels;
    for (std::size_t b = range.first; b < range.end; ++b) {
        if (!pixels.is_occupied(b)) {
            continue;
        }
        for (std::size_t at = 0; at < hal::block_pixels; at += lanes) {
            if (const std::uint32_t bits = load_bits(pixels.enable, b * hal::block_pixels + at)) {
                body(b, at, bits);
            }
        }
    }
}

/// Calls body(block number, at) -> enabled bits for every vector, enabled or not.
template <typename Body>
HWY_INLINE void set_everywhere(Board& board, BlockRange range, const Body& body) {
    PixelArray& pixels = board.pixels;
    for (std::size_t b = range.first; b < range.end; ++b) {
        std::uint32_t any = 0;
        for (std::size_t at = 0; at < hal::block_pixels; at += lanes) {
            const std::uint32_t bits = body(b, at) & all_lanes;
            store_bits(pixels.enable, b * hal::block_pixels + at, bits);
            any |= bits;
        }
        pixels.set_occupied(b, any != 0);
    }
}

/// Sets the carries of the enabled pixels `bits` to those of `carry`.
HWY_INLINE void set_carry(Board& board, std::size_t b, std::size_t at, std::uint32_t bits,
                          M carry) {
    const std::size_t index = b * hal::block_pixels + at;
    const std::uint32_t kept = load_bits(board.pixels.carry, index) & ~bits;
    store_bits(board.pixels.carry, index, kept | (bits_of(carry) & bits));
}

/// Names a number type in a call.
template <typename N>
struct As {
    using Number = N;
};

/// Calls body(As<Narrow>) if n bits fit 32 bits, else body(As<Wide>).
template <typename Body>
HWY_INLINE void by_width(std::uint32_t n, const Body& body) {
    if (n <= 32) {
        body(As<Narrow>());
    } else {
        body(As<Wide>());
    }
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PXPL5_FAST_VECTOR_INL
