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

}  // namespace pxpl5::gp
