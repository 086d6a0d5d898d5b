// Rows of the group `arithmetic`.
#include "isa/reference/bits.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::isa::reference {

void mem_plus_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        const Sum sum = add(read(p, o.a, o.n), read(p, o.b, o.n), false);
        write(p, o.a, sum.bits);
        p.carry = sum.carry;
    });
}

void mem_minus_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        const Sum difference = subtract(read(p, o.a, o.n), read(p, o.b, o.n));
        write(p, o.a, difference.bits);
        p.carry = difference.carry;
    });
}

void mem_plus_const(PixelArray& pixels, Operands o, Coefficients k) {
    each_enabled(pixels, [&](Pixel& p) {
        const Sum sum = add(read(p, o.a, o.n), low_bits(k[0], o.n), false);
        write(p, o.a, sum.bits);
        p.carry = sum.carry;
    });
}

void mem_satplus_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        const Sum sum = add(read(p, o.a, o.n), read(p, o.b, o.n), false);
        write(p, o.a, sum.carry ? inverted(Bits(o.n)) : sum.bits);
        p.carry = sum.carry;
    });
}

void mem_satminus_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        const Sum difference = subtract(read(p, o.a, o.n), read(p, o.b, o.n));
        write(p, o.a, difference.carry ? Bits(o.n) : difference.bits);
        p.carry = difference.carry;
    });
}

void neg_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, negated(read(p, o.a, o.n))); });
}

void abs_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        const Bits value = read(p, o.a, o.n);
        write(p, o.a, value.sign() ? negated(value) : value);
    });
}

void mul_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        write(p, o.a, product(read(p, o.a, o.n), read(p, o.b, o.n), false));
    });
}

void mul_mem_s(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        write(p, o.a, product(read(p, o.a, o.n), read(p, o.b, o.n), true));
    });
}

void mul_const(PixelArray& pixels, Operands o, Coefficients k) {
    each_enabled(pixels, [&](Pixel& p) {
        write(p, o.a, product(read(p, o.b, o.n), low_bits(k[0], o.n), true));
    });
}

namespace {

/// Shifts `value` up by one bit. `low` becomes the lowest bit; the top bit is lost.
Bits shifted_up(Bits value, bool low) {
    for (std::uint32_t i = value.count - 1; i > 0; --i) {
        value[i] = value[i - 1];
    }
    value[0] = low;
    return value;
}

/// Restoring division. A divisor of 0 always fits, so the quotient is all ones.
Bits quotient(const Bits& dividend, const Bits& divisor) {
    Bits result(dividend.count);
    Bits remainder(dividend.count + 1);
    const Bits wide_divisor = resized(divisor, dividend.count + 1, false);
    for (std::uint32_t i = dividend.count; i-- > 0;) {
        remainder = shifted_up(remainder, dividend[i]);
        const Sum rest = subtract(remainder, wide_divisor);
        result[i] = !rest.carry;
        remainder = rest.carry ? remainder : rest.bits;
    }
    return result;
}

/// Restoring square root: two bits of the number per bit of the root. Needs n + 2 bits.
Bits square_root(const Bits& number) {
    const std::uint32_t pairs = (number.count + 1) / 2;
    const Bits padded = resized(number, 2 * pairs, false);
    Bits root(number.count + 2), remainder(number.count + 2);
    for (std::uint32_t i = pairs; i-- > 0;) {
        remainder = shifted_up(shifted_up(remainder, padded[2 * i + 1]), padded[2 * i]);
        const Sum rest = subtract(remainder, shifted_up(shifted_up(root, false), true));
        root = shifted_up(root, !rest.carry);
        remainder = rest.carry ? remainder : rest.bits;
    }
    return resized(root, number.count, false);
}

}  // namespace

void div_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels,
                 [&](Pixel& p) { write(p, o.a, quotient(read(p, o.a, o.n), read(p, o.b, o.n))); });
}

void sqrt_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, square_root(read(p, o.a, o.n))); });
}

}  // namespace pxpl5::isa::reference
