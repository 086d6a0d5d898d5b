#include "gp_firmware/surface/classify.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <type_traits>

#include "gp_firmware/surface/compare_row.hpp"
#include "gp_firmware/volume/typed.hpp"

namespace pxpl5::gp {

namespace {

/// Returns the least T at or above isovalue, so that value >= isovalue equals value >= threshold.
template <class T>
T threshold_of(double isovalue) {
    if constexpr (std::is_integral_v<T>) {
        const double least = std::numeric_limits<T>::min();
        return static_cast<T>(std::max(std::ceil(isovalue), least));
    } else {
        const T rounded = static_cast<T>(isovalue);
        constexpr T infinity = std::numeric_limits<T>::infinity();
        return static_cast<double>(rounded) < isovalue ? std::nextafter(rounded, infinity)
                                                       : rounded;
    }
}

/// Sets all bits x < nx.
void fill_mask(int nx, std::span<std::uint64_t> mask) {
    std::fill(mask.begin(), mask.end(), ~std::uint64_t{0});
    const int spare = static_cast<int>(mask.size()) * 64 - nx;
    mask.back() >>= spare;
}

}  // namespace

void mask_from_voxels(Scalar type, const std::byte* row, int nx, double isovalue,
                      std::span<std::uint64_t> mask) {
    assert(mask.size() == mask_words(nx));
    with_scalar(type, [&]<class T>(T) {
        const std::span<const std::byte> bytes(row, static_cast<std::size_t>(nx) * sizeof(T));
        compare_row(typed<T>(bytes), static_cast<std::size_t>(nx), threshold_of<T>(isovalue),
                    mask.data());
    });
}

RowSide classify_row(const VolumeShape& shape, const HeldSlice& slice, int y, double isovalue,
                     std::span<std::uint64_t> mask) {
    const RowSide side = side_of(slice.rows.ranges[static_cast<std::size_t>(y)], isovalue);
    if (side == RowSide::outside) {
        std::fill(mask.begin(), mask.end(), std::uint64_t{0});
    } else if (side == RowSide::inside) {
        fill_mask(shape.nx, mask);
    } else if (const auto runs = slice.rows.runs_of(y); !runs.empty()) {
        mask_from_runs(runs, isovalue, mask);
    } else {
        const std::size_t row_bytes = static_cast<std::size_t>(shape.nx) * size_bytes(shape.type);
        mask_from_voxels(shape.type, slice.values.data() + static_cast<std::size_t>(y) * row_bytes,
                         shape.nx, isovalue, mask);
    }
    return side;
}

}  // namespace pxpl5::gp
