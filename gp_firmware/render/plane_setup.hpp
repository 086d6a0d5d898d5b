// Plane set-up: a triangle's edges and attribute planes, as exact integers.
#pragma once

#include <array>
#include <cstdint>

#include "gp_firmware/geometry/transform.hpp"

namespace pxpl5::gp {

/// E(px, py) = a * px + b * py + c over the picture's pixels. Inside, by the top-left rule, is
/// exactly where E >= 0 for all three edges.
struct Edge {
    std::int64_t a = 0, b = 0, c = 0;
};

/// Twice the triangle's signed area in 1/256 px^2; positive if its corners run clockwise on the
/// screen (y down).
std::int64_t determinant(const ScreenVertex& v0, const ScreenVertex& v1, const ScreenVertex& v2);

/// Edges v0-v1, v1-v2, v2-v0 of a triangle of positive determinant.
std::array<Edge, 3> edges_of(const ScreenVertex& v0, const ScreenVertex& v1,
                             const ScreenVertex& v2);

/// The planes of z, nx, ny and nz over the picture's pixels: value = floor(Q / 2^fraction),
/// Q = a * px + b * py + c. Slopes are rounded to nearest, c is exact from the rounded slopes at
/// v0. Only the low 32 bits of each are kept: rows of the instruction set read no more.
struct AttributePlanes {
    std::array<std::uint32_t, 4> a{}, b{}, c{};
};

/// `det` is the triangle's determinant, not 0.
AttributePlanes planes_of(const ScreenVertex& v0, const ScreenVertex& v1, const ScreenVertex& v2,
                          std::int64_t det);

}  // namespace pxpl5::gp
