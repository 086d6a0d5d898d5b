// Masks with one bit per voxel: 1 inside the surface, 0 outside.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "gp_firmware/volume/slice_store.hpp"

namespace pxpl5::gp {

constexpr std::size_t mask_words(int nx) {
    return (static_cast<std::size_t>(nx) + 63) / 64;
}

enum class RowSide : std::uint8_t { outside, inside, mixed };

/// Returns the side of a row or slice from its range; mixed if the range does not decide.
inline RowSide side_of(const Range& range, double isovalue) {
    if (static_cast<double>(range.minimum) >= isovalue) {
        return RowSide::inside;
    }
    return static_cast<double>(range.maximum) >= isovalue ? RowSide::mixed : RowSide::outside;
}

/// Sets bit x of `mask` where the voxel is at or above `isovalue`; a NaN is not. Other bits are 0.
/// row       nx voxels of `type`, aligned.
/// isovalue  Not above the row's maximum.
/// mask      mask_words(nx) words.
void mask_from_voxels(Scalar type, const std::byte* row, int nx, double isovalue,
                      std::span<std::uint64_t> mask);

/// Computes the mask of row y from its range, its runs or its voxels, whichever is cheapest.
RowSide classify_row(const VolumeShape& shape, const HeldSlice& slice, int y, double isovalue,
                     std::span<std::uint64_t> mask);

}  // namespace pxpl5::gp
