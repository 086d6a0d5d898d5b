// Group control, fast: the one row that acts on pixels.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/control.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

void pixels_to_fb(Board& board, [[maybe_unused]] BlockRange range, Operands o, Coefficients) {
    assert(range.first == 0 && range.end == hal::block_count);
    const Field<Narrow> from(o.a, o.n);
    for (std::size_t b = 0; b < hal::block_count; ++b) {
        HWY_ALIGN std::uint32_t words[hal::block_pixels];
        for (std::size_t at = 0; at < hal::block_pixels; at += lanes) {
            hn::Store(from.load(board.pixels.blocks[b], at).lo, D(), words + at);
        }
        board.port.put(b, words);
    }
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
