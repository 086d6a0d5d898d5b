// The inside voxels of the last two rows in both slices of a slab.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/surface/cell_row.hpp"
#include "gp_firmware/surface/classify.hpp"

namespace pxpl5::gp {

/// Masks of rows y and y - 1, where y is the row classified last. The functions below find a row by
/// its parity, y & 1.
class RowMasks {
  public:
    RowMasks(const SliceStore& store, int slab, double isovalue);

    /// Classifies row y in both slices. Replaces row y - 2.
    void classify(int y) {
        const auto parity = static_cast<std::size_t>(y & 1);
        for (const std::size_t s : {0U, 1U}) {
            sides_[parity][s] = classify_row(shape_, *slices_[s], y, isovalue_,
                                             std::span(masks_[parity][s]).first(word_count_));
        }
    }

    /// Returns a mask of word_count() + 1 words. The last word is 0, so that each word has a right
    /// neighbor.
    const std::uint64_t* mask(std::size_t parity, std::size_t slice) const {
        return masks_[parity][slice].data();
    }
    std::size_t word_count() const { return word_count_; }
    RowSide side(std::size_t parity, std::size_t slice) const { return sides_[parity][slice]; }

    /// Returns false if the ranges of the four rows show that the surface crosses no cell between
    /// them.
    bool may_cross() const {
        const RowSide side = sides_[0][0];
        return side == RowSide::mixed || sides_[0][1] != side || sides_[1][0] != side ||
               sides_[1][1] != side;
    }

    /// Returns the masks of the cells above the row of the given parity.
    CellMasks cells_above(std::size_t parity) const {
        return {mask(parity, 0), mask(1 - parity, 0), mask(parity, 1), mask(1 - parity, 1)};
    }

  private:
    const VolumeShape& shape_;
    std::array<const HeldSlice*, 2> slices_;
    double isovalue_;
    std::size_t word_count_;
    std::array<std::array<std::vector<std::uint64_t>, 2>, 2> masks_;  ///< [parity][slice]
    std::array<std::array<RowSide, 2>, 2> sides_{};                   ///< [parity][slice]
};

}  // namespace pxpl5::gp
