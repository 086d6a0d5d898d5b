// Smooth gradients: weighted means over 3 x 3 x 3 voxels.
#pragma once

#include <array>
#include <cstddef>

#include "gp_firmware/volume/gradient.hpp"

namespace pxpl5::gp {

/// Sum of the weights of a component of a gradient: (1, 2, 1) times (1, 2, 1).
inline constexpr double smooth_weight = 16;

/// Returns four times the mean of neighbors along an axis. At the volume's border the value itself,
/// which has neighbors on one side only, so that the mean of a linear field is exact there, too.
inline double weighted(double before, double here, double after, bool is_at_border) {
    return is_at_border ? 4 * here : before + 2 * here + after;
}

/// The contribution of the voxels at one x to a gradient: sums over 3 x 3 voxels in y and z.
struct GradientColumn {
    double mean;            ///< 16 times the mean of the values.
    double rise_y, rise_z;  ///< Differences along one axis, weighted along the other.
};

/// The nine rows of voxels around row y of a slice. Rows outside the volume repeat the border row.
template <class T>
class RowsAround {
  public:
    /// slices  nx * ny voxels each: below, here, above.
    /// at_end  Whether below or above is `here`.
    RowsAround(const std::array<const T*, 3>& slices, std::size_t nx, std::size_t ny, std::size_t y,
               bool at_end)
        : y_border_(y == 0 || y + 1 == ny), z_border_(at_end) {
        const std::array<std::size_t, 3> ys{y == 0 ? 0 : y - 1, y, y + 1 == ny ? y : y + 1};
        for (std::size_t z = 0; z < 3; ++z) {
            for (std::size_t row = 0; row < 3; ++row) {
                rows_[z][row] = slices[z] + ys[row] * nx;
            }
        }
    }

    /// Returns the sums of the voxels at x.
    GradientColumn column(std::size_t x) const {
        std::array<double, 3> mean, rise;  // Along z, of each row.
        for (std::size_t row = 0; row < 3; ++row) {
            const auto below = static_cast<double>(rows_[0][row][x]);
            const auto here = static_cast<double>(rows_[1][row][x]);
            const auto above = static_cast<double>(rows_[2][row][x]);
            mean[row] = weighted(below, here, above, z_border_);
            rise[row] = above - below;
        }
        // A difference at the border is one-sided, and counts twice.
        return {weighted(mean[0], mean[1], mean[2], y_border_),
                (mean[2] - mean[0]) * (y_border_ ? 2 : 1),
                weighted(rise[0], rise[1], rise[2], y_border_) * (z_border_ ? 2 : 1)};
    }

  private:
    std::array<std::array<const T*, 3>, 3> rows_;  ///< By slice and row.
    bool y_border_, z_border_;
};

/// Returns the gradient from the columns at x - 1, x and x + 1. At the border, the column outside
/// the volume repeats the border column.
///
/// store  Makes a component of a gradient from a weighted sum.
template <class Store>
Gradient smooth_gradient(const GradientColumn& before, const GradientColumn& here,
                         const GradientColumn& after, bool is_at_border, Store store) {
    return {store((after.mean - before.mean) * (is_at_border ? 2 : 1)),
            store(weighted(before.rise_y, here.rise_y, after.rise_y, is_at_border)),
            store(weighted(before.rise_z, here.rise_z, after.rise_z, is_at_border))};
}

}  // namespace pxpl5::gp
