// Rows of the group `memory`.
#include "isa/reference/bits.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::isa::reference {

void mem_into_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, read(p, o.b, o.n)); });
}

void const_into_mem(PixelArray& pixels, Operands o, Coefficients k) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, low_bits(k[0], o.n)); });
}

void imm_into_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, low_bits(o.b, o.n)); });
}

void clear_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, Bits(o.n)); });
}

void not_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) { write(p, o.a, inverted(read(p, o.a, o.n))); });
}

void mem_and_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        Bits value = read(p, o.a, o.n);
        const Bits other = read(p, o.b, o.n);
        for (std::uint32_t i = 0; i < o.n; ++i) {
            value[i] = value[i] && other[i];
        }
        write(p, o.a, value);
    });
}

void mem_or_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        Bits value = read(p, o.a, o.n);
        const Bits other = read(p, o.b, o.n);
        for (std::uint32_t i = 0; i < o.n; ++i) {
            value[i] = value[i] || other[i];
        }
        write(p, o.a, value);
    });
}

void mem_xor_mem(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        Bits value = read(p, o.a, o.n);
        const Bits other = read(p, o.b, o.n);
        for (std::uint32_t i = 0; i < o.n; ++i) {
            value[i] = value[i] != other[i];
        }
        write(p, o.a, value);
    });
}

void mem_lt_mem(PixelArray& pixels, Operands o, Coefficients) {
    keep_where(pixels, [&](const Pixel& p) { return less(read(p, o.a, o.n), read(p, o.b, o.n)); });
}

void mem_lt_mem_s(PixelArray& pixels, Operands o, Coefficients) {
    keep_where(pixels,
               [&](const Pixel& p) { return less_signed(read(p, o.a, o.n), read(p, o.b, o.n)); });
}

void mem_eq_mem(PixelArray& pixels, Operands o, Coefficients) {
    keep_where(pixels, [&](const Pixel& p) { return equal(read(p, o.a, o.n), read(p, o.b, o.n)); });
}

void mem_eq_const(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels,
               [&](const Pixel& p) { return equal(read(p, o.a, o.n), low_bits(k[0], o.n)); });
}

void mem_ge_const(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels,
               [&](const Pixel& p) { return !less(read(p, o.a, o.n), low_bits(k[0], o.n)); });
}

void mem_lt_const(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels,
               [&](const Pixel& p) { return less(read(p, o.a, o.n), low_bits(k[0], o.n)); });
}

void mem_ge_const_s(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels, [&](const Pixel& p) {
        return !less_signed(read(p, o.a, o.n), low_bits(k[0], o.n));
    });
}

void mem_lt_const_s(PixelArray& pixels, Operands o, Coefficients k) {
    keep_where(pixels,
               [&](const Pixel& p) { return less_signed(read(p, o.a, o.n), low_bits(k[0], o.n)); });
}

}  // namespace pxpl5::isa::reference
