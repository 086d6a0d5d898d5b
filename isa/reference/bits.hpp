// Numbers as sequences of single bits, least significant first, as in the pixel processors.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "isa/reference/pixel_array.hpp"

namespace pxpl5::isa::reference {

inline constexpr std::uint32_t max_bits = 65;  ///< The widest field plus one bit.

/// Up to 65 bits, least significant first. Bits from `count` on are 0.
struct Bits {
    std::array<bool, max_bits> bit{};
    std::uint32_t count = 0;

    explicit Bits(std::uint32_t n) : count(n) { assert(n <= max_bits); }
    bool& operator[](std::uint32_t i) { return bit[i]; }
    bool operator[](std::uint32_t i) const { return bit[i]; }
    bool sign() const { return bit[count - 1]; }
};

/// Returns field m[a : a+n) of a pixel.
inline Bits read(const Pixel& pixel, std::uint32_t a, std::uint32_t n) {
    Bits value(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        value[i] = pixel.m[a + i];
    }
    return value;
}

/// Stores all bits of `value` at m[a].
inline void write(Pixel& pixel, std::uint32_t a, const Bits& value) {
    for (std::uint32_t i = 0; i < value.count; ++i) {
        pixel.m[a + i] = value[i];
    }
}

/// Returns the low n bits of a signed number. Bits beyond the 64th repeat the sign.
inline Bits low_bits(std::int64_t number, std::uint32_t n) {
    Bits value(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        value[i] = ((number >> (i < 63 ? i : 63)) & 1) != 0;
    }
    return value;
}

/// Returns `value` with all bits inverted.
inline Bits inverted(Bits value) {
    for (std::uint32_t i = 0; i < value.count; ++i) {
        value[i] = !value[i];
    }
    return value;
}

/// Returns `value` in n bits: truncated, or extended with `fill`.
inline Bits resized(const Bits& value, std::uint32_t n, bool fill) {
    Bits wide(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        wide[i] = i < value.count ? value[i] : fill;
    }
    return wide;
}

struct Sum {
    Bits bits;
    bool carry;  ///< Carry out of the last bit.
};

/// Returns p + q + carry, computed bit by bit with one full adder.
inline Sum add(const Bits& p, const Bits& q, bool carry) {
    assert(p.count == q.count);
    Bits sum(p.count);
    for (std::uint32_t i = 0; i < p.count; ++i) {
        sum[i] = p[i] ^ q[i] ^ carry;
        carry = (p[i] && q[i]) || (carry && (p[i] ^ q[i]));
    }
    return {sum, carry};
}

/// Returns p - q; `carry` is the borrow.
inline Sum subtract(const Bits& p, const Bits& q) {
    const Sum sum = add(p, inverted(q), true);
    return {sum.bits, !sum.carry};
}

/// Returns -p in two's complement.
inline Bits negated(const Bits& p) {
    return add(inverted(p), Bits(p.count), true).bits;
}

inline bool equal(const Bits& p, const Bits& q) {
    return p.count == q.count && p.bit == q.bit;
}

inline bool less(const Bits& p, const Bits& q) {
    return subtract(p, q).carry;
}

/// Returns p < q in two's complement: less() with the sign bits exchanged.
inline bool less_signed(Bits p, Bits q) {
    p[p.count - 1] = !p[p.count - 1];
    q[q.count - 1] = !q[q.count - 1];
    return less(p, q);
}

/// Returns the 2n-bit product of two n-bit numbers, by shift and add.
inline Bits product(const Bits& p, const Bits& q, bool is_signed) {
    const std::uint32_t n = p.count;
    Bits sum(2 * n);
    Bits addend = resized(p, 2 * n, is_signed && p.sign());
    const Bits factor = resized(q, 2 * n, is_signed && q.sign());
    for (std::uint32_t i = 0; i < 2 * n; ++i) {
        if (factor[i]) {
            sum = add(sum, addend, false).bits;
        }
        for (std::uint32_t k = 2 * n - 1; k > 0; --k) {
            addend[k] = addend[k - 1];
        }
        addend[0] = false;
    }
    return sum;
}

/// Calls the function for all pixels of the scope.
template <typename Action>
void each(PixelArray& pixels, Action action) {
    const Window& scope = pixels.scope;
    for (int y = scope.y0; y < scope.y0 + scope.height; ++y) {
        for (int x = scope.x0; x < scope.x0 + scope.width; ++x) {
            action(pixels.at(x, y));
        }
    }
}

template <typename Action>
void each_enabled(PixelArray& pixels, Action action) {
    each(pixels, [&](Pixel& pixel) {
        if (pixel.enable) {
            action(pixel);
        }
    });
}

/// Clears the enable bit where `test` fails.
template <typename Test>
void keep_where(PixelArray& pixels, Test test) {
    each_enabled(pixels, [&](Pixel& pixel) { pixel.enable = test(pixel); });
}

}  // namespace pxpl5::isa::reference
