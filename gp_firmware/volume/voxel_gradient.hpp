// Gradients of single voxels, for volumes whose gradients are not stored.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "gp_firmware/volume/gradient.hpp"
#include "gp_firmware/volume/smooth_gradient.hpp"
#include "gp_firmware/volume/typed.hpp"

namespace pxpl5::gp {

inline constexpr int largest_gradient = std::numeric_limits<std::int16_t>::max();

/// Stores differences unscaled. The clamp only acts if the announced range is wrong.
struct ExactDifference {
    template <class T>
    std::int16_t operator()(T after, T before, int factor) const {
        const int difference = (static_cast<int>(after) - static_cast<int>(before)) * factor;
        return static_cast<std::int16_t>(
            std::clamp(difference, -largest_gradient, largest_gradient));
    }
};

/// Stores scaled differences. NaN and infinities become 0.
struct ScaledDifference {
    double scale;

    template <class T>
    std::int16_t operator()(T after, T before, int factor) const {
        return (*this)((static_cast<double>(after) - static_cast<double>(before)) * factor);
    }

    std::int16_t operator()(double difference) const {
        const double scaled = difference * scale;
        if (!std::isfinite(scaled)) {
            return 0;
        }
        const double limit = largest_gradient;
        return static_cast<std::int16_t>(std::floor(std::clamp(scaled, -limit, limit) + 0.5));
    }
};

/// Estimates single gradients of one slice, with the same bits as estimate_gradients().
template <class T>
class VoxelGradients {
  public:
    VoxelGradients() = default;
    VoxelGradients(const VolumeShape& shape, const SliceNeighbors& slices)
        : below_(typed<T>(slices.below)),
          here_(typed<T>(slices.here)),
          above_(typed<T>(slices.above)),
          nx_(shape.nx),
          ny_(shape.ny),
          z_factor_(slices.at_end ? 2 : 1),
          scale_(gradient_scale(shape)) {}

    /// GradientKernel::central.
    Gradient central(std::size_t x, std::size_t y) const {
        if constexpr (std::is_integral_v<T>) {
            if (scale_ == 1) {
                return differences(x, y, ExactDifference{});
            }
        }
        return differences(x, y, ScaledDifference{scale_});
    }

    /// GradientKernel::smooth.
    Gradient smooth(std::size_t x, std::size_t y) const {
        const RowsAround<T> rows({below_, here_, above_}, static_cast<std::size_t>(nx_),
                                 static_cast<std::size_t>(ny_), y, z_factor_ == 2);
        const bool first = x == 0, last = x + 1 == static_cast<std::size_t>(nx_);
        return smooth_gradient(rows.column(first ? x : x - 1), rows.column(x),
                               rows.column(last ? x : x + 1), first || last,
                               ScaledDifference{scale_ / smooth_weight});
    }

  private:
    template <class Store>
    Gradient differences(std::size_t x, std::size_t y, Store store) const {
        const std::size_t nx = static_cast<std::size_t>(nx_), i = y * nx + x;
        const bool x_first = x == 0, x_last = x + 1 == nx;
        const bool y_first = y == 0, y_last = y + 1 == static_cast<std::size_t>(ny_);
        return {
            store(here_[x_last ? i : i + 1], here_[x_first ? i : i - 1], x_first || x_last ? 2 : 1),
            store(here_[y_last ? i : i + nx], here_[y_first ? i : i - nx],
                  y_first || y_last ? 2 : 1),
            store(above_[i], below_[i], z_factor_)};
    }

    const T *below_ = nullptr, *here_ = nullptr, *above_ = nullptr;
    int nx_ = 0, ny_ = 0, z_factor_ = 1;
    double scale_ = 1;
};

}  // namespace pxpl5::gp
