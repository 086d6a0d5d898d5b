// Rows of the group `control` that act on pixels. The sequencer runs the other rows.
#include "isa/reference/bits.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::isa::reference {

void pixels_to_fb(PixelArray& pixels, Operands o, Coefficients) {
    std::vector<std::uint32_t> words(region_pixels);
    each(pixels, [&](const Pixel& p) {
        std::uint32_t& word = words[static_cast<std::size_t>(p.y * region_px + p.x)];
        for (std::uint32_t i = 0; i < o.n; ++i) {
            word |= static_cast<std::uint32_t>(p.m[o.a + i]) << i;
        }
    });
    pixels.readout(words);
}

}  // namespace pxpl5::isa::reference
