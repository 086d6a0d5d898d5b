// The runs of equal values that a slice's rows consist of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace pxpl5::host::timing {

/// A slice's rows.
struct SliceShape {
    std::uint32_t nx = 0, ny = 0;   ///< Voxels; both at least 1.
    std::uint32_t voxel_bytes = 0;  ///< 1, 2 or 4.
};

/// Runs of the slice, summed over its rows: a run is a longest stretch along x of voxels with the
/// same bits.
/// values  nx * ny voxels, x fastest.
/// Returns ny .. nx * ny.
/// Source  Yoo & Chen, section V: rows are kept as runs, which extraction passes over.
std::uint64_t runs_of(std::span<const std::byte> values, SliceShape shape);

}  // namespace pxpl5::host::timing
