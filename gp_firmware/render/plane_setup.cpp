#include "gp_firmware/render/plane_setup.hpp"

namespace pxpl5::gp::setup {

namespace {

/// Returns the rounded quotient of integers that exceed the precision of a double.
std::uint64_t exact_slope(std::int64_t numerator, unsigned scale_bits, std::int64_t det) {
    const std::int64_t twice = numerator * (std::int64_t{2} << scale_bits) + det;
    const std::int64_t cut = twice / (2 * det);
    // The determinant is positive. Rounds down, not toward 0.
    return static_cast<std::uint64_t>(cut - (twice % (2 * det) < 0 ? 1 : 0));
}

}  // namespace

Slopes exact_slopes(const ScreenVertex& v0, const ScreenVertex& v1, const ScreenVertex& v2,
                    std::int64_t det) {
    const std::int64_t x1 = v1.x - v0.x, y1 = v1.y - v0.y, x2 = v2.x - v0.x, y2 = v2.y - v0.y;
    const Values at0 = values_of(v0), at1 = values_of(v1), at2 = values_of(v2);
    Slopes slopes{};
    for (std::size_t k = 0; k < 4; ++k) {
        const std::int64_t d1 = at1[k] - at0[k], d2 = at2[k] - at0[k];
        slopes.a[k] = exact_slope(d1 * y2 - d2 * y1, shift + fraction[k], det);
        slopes.b[k] = exact_slope(d2 * x1 - d1 * x2, shift + fraction[k], det);
    }
    return slopes;
}

}  // namespace pxpl5::gp::setup
