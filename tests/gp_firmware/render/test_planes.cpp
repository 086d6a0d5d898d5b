// Attribute planes against exact rational arithmetic.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>

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

/// The value that TREEintoMEM stores for plane k at the region-independent pixel (px, py).
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

/// Whether `slope` is the low half of numerator / det * 2^bits, rounded to nearest. Within 2^-11 of
/// half-way, where a double may not know better, the other neighbor is right too.
bool is_rounded(std::uint32_t slope, Wide numerator, Wide det, unsigned bits) {
    const Wide twice = (numerator << (bits + 1)) + det;
    Wide floor = twice / (2 * det), rest = twice % (2 * det);
    if (rest < 0) {
        --floor;
        rest += 2 * det;
    }
    const auto off = slope - static_cast<std::uint32_t>(floor);
    return off == 0 || (off == 0xFFFFFFFF && rest * 2048 < 2 * det) ||
           (off == 1 && (2 * det - rest) * 2048 < 2 * det);
}

void check_slopes(const Triangle& t) {
    const auto planes = gp::planes_of(t[0], t[1], t[2], gp::determinant(t[0], t[1], t[2]));
    for (std::size_t k = 0; k < 4; ++k) {
        const Exact e = exact_plane(t, k);
        CHECK(is_rounded(planes.a[k], e.a, e.det, 4 + fraction[k]));
        CHECK(is_rounded(planes.b[k], e.b, e.det, 4 + fraction[k]));
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
            // A center, and two far corners such that the triangle about it is as thin as it can
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

    TEST_CASE("the steepest slopes of all, of long triangles with the least area, are exact") {
        Random random(5);
        int steep = 0;
        for (int i = 0; i < 3000; ++i) {
            // (x1, y1) and (x2, y2) with x1 * y2 - x2 * y1 = 1, by Euclid's algorithm.
            const int x1 = random.integer(1 << 12, 1 << 17), y1 = random.integer(1 << 12, 1 << 17);
            std::int64_t r0 = x1, r1 = y1, s0 = 1, s1 = 0, t0 = 0, t1 = 1;
            while (r1 != 0) {
                const std::int64_t q = r0 / r1;
                r0 = std::exchange(r1, r0 - q * r1);
                s0 = std::exchange(s1, s0 - q * s1);
                t0 = std::exchange(t1, t0 - q * t1);
            }
            // A corner on a pixel's center: that pixel may be covered.
            Triangle t = {vertex_at(8, 8, random), vertex_at(8 + x1, 8 + y1, random),
                          vertex_at(8 - static_cast<int>(t0), 8 + static_cast<int>(s0), random)};
            const auto positive = oriented(t);
            if (r0 != 1 || !positive) {
                continue;
            }
            ++steep;
            check_slopes(*positive);
            check_values(*positive, std::vector<std::array<int, 2>>{{0, 0}});
        }
        CHECK(steep > 1000);
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
