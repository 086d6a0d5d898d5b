#include "gp_firmware/surface/row_masks.hpp"

namespace pxpl5::gp {

RowMasks::RowMasks(const SliceStore& store, int slab, double isovalue)
    : shape_(store.shape()),
      slices_{&store.slice(slab), &store.slice(slab + 1)},
      isovalue_(isovalue),
      word_count_(mask_words(shape_.nx)) {
    for (auto& masks : masks_) {
        for (auto& mask : masks) {
            mask.assign(word_count_ + 1, 0);
        }
    }
}

void RowMasks::classify(int y) {
    const auto parity = static_cast<std::size_t>(y & 1);
    for (const std::size_t s : {0U, 1U}) {
        sides_[parity][s] = classify_row(shape_, *slices_[s], y, isovalue_,
                                         std::span(masks_[parity][s]).first(word_count_));
    }
}

bool RowMasks::may_cross() const {
    const RowSide side = sides_[0][0];
    return side == RowSide::mixed || sides_[0][1] != side || sides_[1][0] != side ||
           sides_[1][1] != side;
}

}  // namespace pxpl5::gp
