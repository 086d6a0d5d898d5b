// Rows of voxels as runs of equal value, and the range of every row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::gp {

/// Least and greatest value of a row or slice. A NaN voxel counts as minus infinity, because it is
/// outside of every surface. Every scalar type fits into a float exactly.
struct Range {
    float minimum = 0, maximum = 0;
};

/// Equal values from the previous run's end (or 0) up to x = end.
struct Run {
    float value = 0;
    std::uint32_t end = 0;
};

/// Ranges and runs of a slice's rows, for classification without voxels.
///
/// A row keeps its runs if it has at most nx / min_run_length of them.
/// Source  Yoo & Chen, section V: run-length encoding "provides both a mechanism for memory
///         optimization and a means of traversing intervals between isosurface boundaries".
///         Ranges, which serve across rows and slices too, are ours.
struct RowIndex {
    Range slice;                           ///< Over all rows.
    std::vector<Range> ranges;             ///< ny.
    std::vector<std::uint32_t> run_first;  ///< ny + 1; row y has runs run_first[y] .. [y + 1].
    std::vector<Run> runs;

    std::span<const Run> runs_of(int y) const {
        const auto row = static_cast<std::size_t>(y);
        return {runs.data() + run_first[row], runs.data() + run_first[row + 1]};
    }
    std::size_t size_bytes() const;
};

inline constexpr int min_run_length = 8;  ///< Least mean run length of a row that keeps its runs.

/// Returns the index of one slice.
/// values  nx * ny voxels, x fastest, of shape.type.
RowIndex index_rows(const VolumeShape& shape, std::span<const std::byte> values);

/// Returns the size of the largest possible index of one slice.
std::size_t max_index_bytes(const VolumeShape& shape);

/// Sets bit x of `mask` where the row's value is at or above `isovalue`; other bits are 0.
/// mask  (nx + 63) / 64 words, bit x % 64 of word x / 64.
void mask_from_runs(std::span<const Run> runs, double isovalue, std::span<std::uint64_t> mask);

}  // namespace pxpl5::gp
