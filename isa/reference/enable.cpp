// Rows of the group `enable`.
#include "isa/reference/bits.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::isa::reference {

void set_enabs(PixelArray& pixels, Operands, Coefficients) {
    each(pixels, [](Pixel& p) { p.enable = true; });
}

void clr_enabs(PixelArray& pixels, Operands, Coefficients) {
    each(pixels, [](Pixel& p) { p.enable = false; });
}

void inv_enabs(PixelArray& pixels, Operands, Coefficients) {
    each(pixels, [](Pixel& p) { p.enable = !p.enable; });
}

void enab_into_mem(PixelArray& pixels, Operands o, Coefficients) {
    each(pixels, [&](Pixel& p) { p.m[o.a] = p.enable; });
}

void mem_into_enab(PixelArray& pixels, Operands o, Coefficients) {
    each(pixels, [&](Pixel& p) { p.enable = p.m[o.a]; });
}

void enab_and_mem(PixelArray& pixels, Operands o, Coefficients) {
    keep_where(pixels, [&](const Pixel& p) { return p.m[o.a]; });
}

void enab_and_not_mem(PixelArray& pixels, Operands o, Coefficients) {
    keep_where(pixels, [&](const Pixel& p) { return !p.m[o.a]; });
}

void enab_or_mem(PixelArray& pixels, Operands o, Coefficients) {
    each(pixels, [&](Pixel& p) { p.enable = p.enable || p.m[o.a]; });
}

void enab_and_carry(PixelArray& pixels, Operands, Coefficients) {
    keep_where(pixels, [](const Pixel& p) { return p.carry; });
}

}  // namespace pxpl5::isa::reference
