// Rows of the group `backing`. Transfers take effect at once. No program can notice this, because
// check() refuses every use of a field or block under transfer before BSWAIT.
#include "isa/reference/bits.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::isa::reference {

void bs_read(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        const std::uint32_t word = p.blocks.empty() ? 0 : p.blocks[o.b];
        write(p, o.a, low_bits(word, backing_block_bits));
    });
}

void bs_write(PixelArray& pixels, Operands o, Coefficients) {
    each_enabled(pixels, [&](Pixel& p) {
        p.blocks.resize(backing_blocks);
        std::uint32_t word = 0;
        for (std::uint32_t i = 0; i < backing_block_bits; ++i) {
            word |= static_cast<std::uint32_t>(p.m[o.a + i]) << i;
        }
        p.blocks[o.b] = word;
    });
}

}  // namespace pxpl5::isa::reference
