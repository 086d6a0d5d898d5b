// Plane set-up: a triangle's edges and attribute planes, as exact integers.
//
// The functions here handle one triangle and are the definition. set_up_triangles gives the same
// results for many triangles at a time.
#pragma once

#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "gp_firmware/geometry/transform.hpp"

namespace pxpl5::gp {

/// E(px, py) = a * px + b * py + c over the picture's pixels. By the top-left rule, a pixel is
/// inside exactly if E >= 0 for all three edges.
struct Edge {
    std::int64_t a = 0, b = 0, c = 0;
};

namespace setup {

inline constexpr int half = subpixels / 2;  ///< Distance of a pixel's center from its corner.
inline constexpr int shift = isa::region::subpixel_bits;
inline constexpr std::array<unsigned, 4> fraction = {
    isa::region::z_fraction_bits, isa::region::normal_fraction_bits,
    isa::region::normal_fraction_bits, isa::region::normal_fraction_bits};

/// Slopes in units of 2^-fraction per pixel, modulo 2^51.
struct Slopes {
    std::array<std::uint64_t, 4> a, b;
};

using Values = std::array<std::int32_t, 4>;

inline Values values_of(const ScreenVertex& v) {
    return {v.z, v.nx, v.ny, v.nz};
}

/// Returns edge p-q. It is positive to the right of p -> q as seen on the screen.
inline Edge edge(const ScreenVertex& p, const ScreenVertex& q) {
    const std::int64_t a = p.y - q.y, b = q.x - p.x;
    // Centers on a left or top edge are inside; centers on any other edge are outside.
    const bool top_left = a > 0 || (a == 0 && b > 0);
    const std::int64_t c16 = a * (half - p.x) + b * (half - p.y) - (top_left ? 0 : 1);
    return {a, b, c16 >> shift};
}

/// Computes the slopes in integers only. It is slow, and serves slivers whose slopes exceed the 53
/// bits of a double.
Slopes exact_slopes(const ScreenVertex& v0, const ScreenVertex& v1, const ScreenVertex& v2,
                    std::int64_t det);

/// Steeper slopes than this need exact_slopes().
inline constexpr double max_rounded_slope = 0x1p40;
/// Adding this to a double below 2^51 leaves the nearest integer in the low bits.
inline constexpr double to_nearest = 0x1.8p52;

inline Slopes slopes_of(const ScreenVertex& v0, const ScreenVertex& v1, const ScreenVertex& v2,
                        std::int64_t det) {
    const double x1 = v1.x - v0.x, y1 = v1.y - v0.y, x2 = v2.x - v0.x, y2 = v2.y - v0.y;
    const double inverse = 1.0 / static_cast<double>(det);
    const Values at0 = values_of(v0), at1 = values_of(v1), at2 = values_of(v2);
    Slopes slopes{};
    for (std::size_t k = 0; k < 4; ++k) {
        const double d1 = at1[k] - at0[k], d2 = at2[k] - at0[k];
        const double scale = inverse * (1U << (shift + fraction[k]));
        // Numerators are below 2^45 and so exact; scales are powers of 2.
        const double a = (d1 * y2 - d2 * y1) * scale;
        const double b = (d2 * x1 - d1 * x2) * scale;
        if (std::abs(a) > max_rounded_slope || std::abs(b) > max_rounded_slope) [[unlikely]] {
            return exact_slopes(v0, v1, v2, det);
        }
        slopes.a[k] = std::bit_cast<std::uint64_t>(a + to_nearest);
        slopes.b[k] = std::bit_cast<std::uint64_t>(b + to_nearest);
    }
    return slopes;
}

}  // namespace setup

/// Returns twice the triangle's signed area in 1/256 px^2. It is positive if the corners run
/// clockwise on the screen (y down).
inline std::int64_t determinant(const ScreenVertex& v0, const ScreenVertex& v1,
                                const ScreenVertex& v2) {
    const std::int64_t x1 = v1.x - v0.x, y1 = v1.y - v0.y, x2 = v2.x - v0.x, y2 = v2.y - v0.y;
    return x1 * y2 - x2 * y1;
}

/// Returns edges v0-v1, v1-v2, v2-v0 of a triangle of positive determinant.
inline std::array<Edge, 3> edges_of(const ScreenVertex& v0, const ScreenVertex& v1,
                                    const ScreenVertex& v2) {
    return {setup::edge(v0, v1), setup::edge(v1, v2), setup::edge(v2, v0)};
}

/// The planes of z, nx, ny and nz over the picture's pixels: value = floor(Q / 2^fraction),
/// Q = a * px + b * py + c. Slopes are rounded to nearest, c is exact from the rounded slopes at
/// v0. Only the low 32 bits of each are stored, because the instructions read no more.
struct AttributePlanes {
    std::array<std::uint32_t, 4> a{}, b{}, c{};
};

/// det  The triangle's determinant, > 0.
inline AttributePlanes planes_of(const ScreenVertex& v0, const ScreenVertex& v1,
                                 const ScreenVertex& v2, std::int64_t det) {
    assert(det > 0);
    const setup::Slopes slopes = setup::slopes_of(v0, v1, v2, det);
    const setup::Values at0 = setup::values_of(v0);
    // From v0 to the center of pixel (0, 0).
    const auto to_center_x = static_cast<std::uint64_t>(std::int64_t{setup::half - v0.x});
    const auto to_center_y = static_cast<std::uint64_t>(std::int64_t{setup::half - v0.y});
    AttributePlanes planes;
    for (std::size_t k = 0; k < 4; ++k) {
        const std::uint64_t a = slopes.a[k], b = slopes.b[k];
        // Exact modulo 2^51; bits 4..35 are needed. Adds 0.5, because instructions truncate.
        const std::uint64_t value =
            (static_cast<std::uint64_t>(std::int64_t{at0[k]}) << setup::fraction[k]) +
            (std::uint64_t{1} << (setup::fraction[k] - 1));
        const std::uint64_t c = value + ((a * to_center_x + b * to_center_y) >> setup::shift);
        planes.a[k] = static_cast<std::uint32_t>(a);
        planes.b[k] = static_cast<std::uint32_t>(b);
        planes.c[k] = static_cast<std::uint32_t>(c);
    }
    return planes;
}

}  // namespace pxpl5::gp
