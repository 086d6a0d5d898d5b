// Group control, fast: the one row in which pixels take part.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/control.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles what follows once per target.
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

void pixels_to_fb(Board& board, [[maybe_unused]] BlockRange range, Operands o, Coefficients) {
    assert(range.first == 0 && range.end == hal::block_count);
    const Field<Narrow> from(o.a, o.n);
    hal::Port::Words& stored = board.port.stored();
    for (std::size_t b = 0; b < hal::block_count; ++b) {
        for (std::size_t at = 0; at < hal::block_pixels; at += lanes) {
            const V value = from.load(board.pixels.blocks[b], at).lo;
            hn::Store(value, D(), &stored[b * hal::block_pixels + at]);
        }
    }
    board.port.turn();
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
