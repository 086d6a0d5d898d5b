// Rows of the group `tree`: linear with 3 coefficients, quadratic with 6.
#include "isa/reference/bits.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::isa::reference {
namespace {

/// Returns Q at the pixel. |Q| is below 2^47, so 64 bits suffice for Q and all partial sums.
std::int64_t evaluate(const Pixel& p, Coefficients k) {
    const std::int64_t x = p.x, y = p.y;
    std::int64_t q = k[0] * x + k[1] * y + k[2];
    if (k.size() == 6) {
        q += k[3] * x * x + k[4] * x * y + k[5] * y * y;
    }
    return q;
}

/// Returns the low n bits of T = floor(Q / 2^b).
Bits tree(const Pixel& p, Operands o, Coefficients k) {
    return low_bits(evaluate(p, k) >> o.b, o.n);
}

void ge_zero(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels, [&](const Pixel& p) { return !low_bits(evaluate(p, k), o.n).sign(); });
}

void lt_zero(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels, [&](const Pixel& p) { return low_bits(evaluate(p, k), o.n).sign(); });
}

void lt_mem(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels, [&](const Pixel& p) { return less(tree(p, o, k), read(p, o.a, o.n)); });
}

void ge_mem(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels, [&](const Pixel& p) { return !less(tree(p, o, k), read(p, o.a, o.n)); });
}

void into_mem(PixelArray& pixels, Operands o, Coefficients k) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, tree(p, o, k)); });
}

/// Returns 0 if T is negative, all ones if T needs more than n bits, else T.
Bits clamped(std::int64_t t, std::uint32_t n) {
    const Bits zero(n);
    const bool too_large = (t >> n) != 0;
    return t < 0 ? zero : too_large ? inverted(zero) : low_bits(t, n);
}

void clamp_mem(PixelArray& pixels, Operands o, Coefficients k) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, clamped(evaluate(p, k) >> o.b, o.n)); });
}

void plus_tree(PixelArray& pixels, Operands o, Coefficients k) {
    each_enabled(pixels, [&](Pixel& p) {
        const Sum sum = add(read(p, o.a, o.n), tree(p, o, k), false);
        write(p, o.a, sum.bits);
        p.carry = sum.carry;
    });
}

void minus_tree(PixelArray& pixels, Operands o, Coefficients k) {
    each_enabled(pixels, [&](Pixel& p) {
        const Sum difference = subtract(read(p, o.a, o.n), tree(p, o, k));
        write(p, o.a, difference.bits);
        p.carry = difference.carry;
    });
}

}  // namespace

void tree_ge_zero(PixelArray& p, Operands o, Coefficients k) {
    ge_zero(p, o, k);
}
void tree_lt_zero(PixelArray& p, Operands o, Coefficients k) {
    lt_zero(p, o, k);
}
void tree_lt_mem(PixelArray& p, Operands o, Coefficients k) {
    lt_mem(p, o, k);
}
void tree_ge_mem(PixelArray& p, Operands o, Coefficients k) {
    ge_mem(p, o, k);
}
void tree_into_mem(PixelArray& p, Operands o, Coefficients k) {
    into_mem(p, o, k);
}
void tree_clamp_mem(PixelArray& p, Operands o, Coefficients k) {
    clamp_mem(p, o, k);
}
void mem_plus_tree(PixelArray& p, Operands o, Coefficients k) {
    plus_tree(p, o, k);
}
void mem_minus_tree(PixelArray& p, Operands o, Coefficients k) {
    minus_tree(p, o, k);
}

void quad_ge_zero(PixelArray& p, Operands o, Coefficients k) {
    ge_zero(p, o, k);
}
void quad_lt_zero(PixelArray& p, Operands o, Coefficients k) {
    lt_zero(p, o, k);
}
void quad_lt_mem(PixelArray& p, Operands o, Coefficients k) {
    lt_mem(p, o, k);
}
void quad_ge_mem(PixelArray& p, Operands o, Coefficients k) {
    ge_mem(p, o, k);
}
void quad_into_mem(PixelArray& p, Operands o, Coefficients k) {
    into_mem(p, o, k);
}
void quad_clamp_mem(PixelArray& p, Operands o, Coefficients k) {
    clamp_mem(p, o, k);
}
void mem_plus_quad(PixelArray& p, Operands o, Coefficients k) {
    plus_tree(p, o, k);
}
void mem_minus_quad(PixelArray& p, Operands o, Coefficients k) {
    minus_tree(p, o, k);
}

}  // namespace pxpl5::isa::reference
