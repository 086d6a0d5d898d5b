// Attribute planes against exact rational arithmetic.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

__extension__ typedef __int128 Wide;

constexpr std::array<unsigned, 4> fraction = {8, 16, 16, 16};
constexpr std::array<unsigned, 4> width = {24, 10, 10, 10};

std::int32_t value_of(const ScreenVertex& v, std::size_t k) {
    return std::array{v.z, v.nx, v.ny, v.nz}[k];
}

/// The exact plane through the three values: (a * x + b * y + c) / det at the grid point (x, y).
struct Exact {
    Wide a, b, c, det;
    long double at(Wide x, Wide y) const {
        return static_cast<long double>(a * x + b * y + c) / static_cast<long double>(det);
    }
};

Exact exact_plane(const Triangle& t, std::size_t k) {
    const Wide v[3] = {value_of(t[0], k), value_of(t[1], k), value_of(t[2], k)};
    Exact e{0, 0, 0, 0};
    // Cramer's rule on a x_i + b y_i + c = v_i.
    for (std::size_t i = 0; i < 3; ++i) {
        const ScreenVertex &p = t[(i + 1) % 3], &q = t[(i + 2) % 3];
        e.a += v[i] * (p.y - q.y);
        e.b += v[i] * (q.x - p.x);
        e.c += v[i] * (Wide{p.x} * q.y - Wide{q.x} * p.y);
        e.det += Wide{p.x} * q.y - Wide{q.x} * p.y;
    }
    return e;
}

/// What TREEintoMEM stores for plane k at the region-independent pixel (px, py).
std::int64_t stored(const gp::AttributePlanes& planes, std::size_t k, int px, int py) {
    const std::uint32_t q = planes.a[k] * static_cast<std::uint32_t>(px) +
                            planes.b[k] * static_cast<std::uint32_t>(py) + planes.c[k];
    const std::uint32_t field = (q >> fraction[k]) & ((1U << width[k]) - 1);
    const bool is_signed = k > 0;
    return is_signed && field >= 1U << (width[k] - 1)
               ? std::int64_t{field} - (std::int64_t{1} << width[k])
               : std::int64_t{field};
}

/// Checks plane k at all of the given pixels that the triangle covers. Returns how many.
int check_values(const Triangle& t, std::span<const std::array<int, 2>> pixels) {
    const auto planes = gp::planes_of(t[0], t[1], t[2], gp::determinant(t[0], t[1], t[2]));
    int seen = 0, wrong = 0, beyond = 0;
    for (const auto& [px, py] : pixels) {
        if (!covers(t, px, py)) {
            continue;
        }
        ++seen;
        for (std::size_t k = 0; k < 4; ++k) {
            const Exact e = exact_plane(t, k);
            const long double exact = e.at(16 * Wide{px} + 8, 16 * Wide{py} + 8);
            const std::int64_t value = stored(planes, k, px, py);
            // Slopes are off by half a unit of the fraction per pixel from the first corner.
            const long double away =
                (std::abs(16 * px + 8 - t[0].x) + std::abs(16 * py + 8 - t[0].y)) / 16.0L;
            const long double slack = (0.51L * away + 1) / (1U << fraction[k]) + 0.51L;
            wrong += std::abs(static_cast<long double>(value) - exact) > slack ? 1 : 0;
            beyond += k == 0 ? (value < 1 || value > isa::region::z_far - 1 ? 1 : 0)
                             : (std::abs(value) > 511 ? 1 : 0);
        }
    }
    INFO("triangle (", t[0].x, ",", t[0].y, ",", t[0].z, ") (", t[1].x, ",", t[1].y, ",", t[1].z,
         ") (", t[2].x, ",", t[2].y, ",", t[2].z, ") seed ", seed());
    CHECK(wrong == 0);
    CHECK(beyond == 0);
    return seen;
}

/// The exact slope of plane k along x (or y), rounded to nearest, in units of 2^-fraction a pixel.
Wide rounded_slope(Wide numerator, Wide det, unsigned bits) {
    const Wide twice = (numerator << (bits + 1)) + det;
    const Wide cut = twice / (2 * det);
    return cut * 2 * det > twice ? cut - 1 : cut;
}

void check_slopes(const Triangle& t) {
    const auto planes = gp::planes_of(t[0], t[1], t[2], gp::determinant(t[0], t[1], t[2]));
    for (std::size_t k = 0; k < 4; ++k) {
        const Exact e = exact_plane(t, k);
        const auto low = [](Wide w) { return static_cast<std::uint32_t>(w); };
        const std::uint32_t da = planes.a[k] - low(rounded_slope(e.a, e.det, 4 + fraction[k]));
        const std::uint32_t db = planes.b[k] - low(rounded_slope(e.b, e.det, 4 + fraction[k]));
        // Half-way cases may go either way.
        CHECK((da == 0 || da == 1 || da == 0xFFFFFFFF));
        CHECK((db == 0 || db == 1 || db == 0xFFFFFFFF));
    }
}

}  // namespace

TEST_SUITE("gp/planes") {
    TEST_CASE("slopes are the exact ones, rounded, from tiny to huge triangles") {
        Random random(1);
        for (int i = 0; i < 5000; ++i) {
            const int spread = 1 << random.integer(1, 18);
            Triangle t;
            for (ScreenVertex& v : t) {
                v = vertex_at(random.integer(-spread, spread), random.integer(-spread, spread),
                              random);
            }
            if (const auto positive = oriented(t)) {
                check_slopes(*positive);
            }
        }
    }

    TEST_CASE(
        "inside a triangle, depth and normals are exact to rounding and stay in their fields") {
        Random random(2);
        int seen = 0;
        for (int i = 0; i < 2000; ++i) {
            const int spread = 1 << random.integer(4, 18);
            Triangle t;
            for (ScreenVertex& v : t) {
                v = vertex_at(random.integer(-spread, spread), random.integer(-spread, spread),
                              random);
            }
            std::vector<std::array<int, 2>> pixels;
            for (int k = 0; k < 40; ++k) {
                pixels.push_back(
                    {random.integer(-spread, spread) / 16, random.integer(-spread, spread) / 16});
            }
            if (const auto positive = oriented(t)) {
                seen += check_values(*positive, pixels);
            }
        }
        CHECK(seen > 2000);
    }

    TEST_CASE("slivers with the steepest slopes stay in their fields") {
        Random random(3);
        int seen = 0;
        for (int i = 0; i < 20000; ++i) {
            // A centre, and two far corners such that the triangle about it is as thin as it can
            // be.
            const int px = random.integer(0, 511), py = random.integer(0, 511);
            const int length = 1 << random.integer(0, 17);
            const int dx = random.integer(-length, length), dy = random.integer(-length, length);
            const int x = 16 * px + 8, y = 16 * py + 8;
            Triangle t = {
                vertex_at(x + random.integer(-1, 1), y + random.integer(-1, 1), random),
                vertex_at(x + dx, y + dy, random),
                vertex_at(x - dx + random.integer(-1, 1), y - dy + random.integer(-1, 1), random)};
            // Extremes of depth next to each other.
            t[0].z = isa::region::z_margin;
            t[1].z = t[2].z = isa::region::z_far - isa::region::z_margin;
            if (const auto positive = oriented(t)) {
                check_slopes(*positive);
                const std::vector<std::array<int, 2>> pixels = {
                    {px, py}, {px + dx / 32, py + dy / 32}, {px - dx / 32, py - dy / 32}};
                seen += check_values(*positive, pixels);
            }
        }
        CHECK(seen > 1000);
    }

    TEST_CASE("a triangle of unit normals and border depths keeps both at every pixel") {
        Random random(4);
        Triangle t = {vertex_at(0, 0, random), vertex_at(1 << 18, 0, random),
                      vertex_at(0, 1 << 18, random)};
        for (ScreenVertex& v : t) {
            v.z = isa::region::z_far - isa::region::z_margin;
            v.nx = isa::region::normal_unit;
            v.ny = -isa::region::normal_unit;
            v.nz = 0;
        }
        const auto planes = gp::planes_of(t[0], t[1], t[2], gp::determinant(t[0], t[1], t[2]));
        for (int p = 0; p < 8000; p += 97) {
            CHECK(stored(planes, 0, p, p / 2) == isa::region::z_far - isa::region::z_margin);
            CHECK(stored(planes, 1, p, p / 2) == isa::region::normal_unit);
            CHECK(stored(planes, 2, p, p / 2) == -isa::region::normal_unit);
            CHECK(stored(planes, 3, p, p / 2) == 0);
        }
    }
}
