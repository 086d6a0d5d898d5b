// Group backing, fast: transfers between pixel memory and backing store. They take effect at once.
//
// Programs cannot notice this, because check() refuses uses of fields and blocks under transfer.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/backing.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

void bs_read(Board& board, BlockRange range, Operands o, Coefficients) {
    const Field<Narrow> to(o.a, isa::backing_block_bits);
    const hal::BackingStore::Words* words = board.store.find(o.b);
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        const V value = words == nullptr ? hn::Zero(D())
                                         : hn::Load(D(), &words->at[b * hal::block_pixels + at]);
        to.store(board.pixels.blocks[b], at, {value}, mask_of(bits));
    });
}

void bs_write(Board& board, BlockRange range, Operands o, Coefficients) {
    const Field<Narrow> from(o.a, isa::backing_block_bits);
    hal::BackingStore::Words& words = board.store.open(o.b);
    where_enabled(board, range, [&](std::size_t b, std::size_t at, std::uint32_t bits) PXPL5_BODY {
        std::uint32_t* word = &words.at[b * hal::block_pixels + at];
        const V value = from.load(board.pixels.blocks[b], at).lo;
        hn::Store(hn::IfThenElse(mask_of(bits), value, hn::Load(D(), word)), D(), word);
    });
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
