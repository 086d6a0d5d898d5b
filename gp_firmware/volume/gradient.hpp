// Gradients: surface normals come from how values change between voxels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::gp {

/// Central differences at a voxel along x, y, z: (value after - value before) * gradient_scale().
/// At the volume's border, twice the one-sided difference. 0 where a value is not finite.
/// GradientKernel::smooth: the mean of the differences at the voxel and its neighbors across the
/// axis, with the weights 1, 2, 1 along each of both other axes.
/// Gradients ignore the voxel spacing; NormalFrame applies it.
using Gradient = std::array<std::int16_t, 3>;

/// Returns the factor from differences of values to stored gradients. It is 1 for central
/// differences of integers if twice the volume's range fits into 16 bits, because a difference at
/// the border can be so large. Otherwise it scales twice the range to 16 bits.
double gradient_scale(const VolumeShape& shape);

/// A slice and its neighbors in z; below or above is the slice itself at the volume's ends.
struct SliceNeighbors {
    std::span<const std::byte> below, here, above;  ///< Each nx * ny of shape.type, aligned.
    bool at_end = false;                            ///< Whether below or above is `here`.
};

/// Returns the nx * ny gradients of slice `here`.
/// Source  Central differences: Yoo & Chen, section IV, "Gradient estimation". One-sided ones are
///         ours: the paper does not say. Smooth ones: the operator of Sobel in three dimensions.
std::vector<Gradient> estimate_gradients(const VolumeShape& shape, const SliceNeighbors& slices);

}  // namespace pxpl5::gp
