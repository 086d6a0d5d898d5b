// How often each range of values occurs in a volume.
#pragma once

#include <cstdint>
#include <vector>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

inline constexpr int max_histogram_bins = 65536;
inline constexpr int window_bins = 256;  ///< For windows of gray values, as in the viewer.

struct Histogram {
    double first = 0;  ///< Lower end of bin 0.
    /// Width of a bin: bin b counts first + b * width <= value < first + (b + 1) * width. If values
    /// are not whole numbers, the last bin includes its upper end.
    double width = 1;
    std::vector<std::uint64_t> counts;  ///< Empty if no voxel is finite.
    std::uint64_t not_finite = 0;       ///< Voxels that are NaN or infinite; in no bin.
};

/// Counts all voxels, or those of the copy that the host keeps (host/volume/reduced.hpp), from the
/// least finite value to the greatest. bins     1..max_histogram_bins (asserted). Whole numbers get
/// bins of a whole width, so that none
///          looks fuller than its neighbors for holding one value more; then there may be fewer.
Histogram histogram(const Volume& volume, int bins);

}  // namespace pxpl5::host
