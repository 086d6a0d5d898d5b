#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gp_firmware/render/set_up_triangles.cpp"
#include <hwy/foreach_target.h>
// highway.h must follow foreach_target.h, which compiles this file once per target.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstring>

#include "gp_firmware/geometry/lanes-inl.hpp"
#include "gp_firmware/render/plane_setup.hpp"
#include "gp_firmware/render/region_programs.hpp"
#include "gp_firmware/render/set_up_triangles.hpp"
#include "gp_firmware/render/triangle_program.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

namespace shape = isa::triangle;

using DD = hn::Repartition<double, DI>;
using D = hn::Vec<DD>;
using Half = hn::Half<DI>;

HWY_INLINE U word(std::uint32_t value) {
    return hn::Set(DU(), value);
}
HWY_INLINE U bits_of(I v) {
    return hn::BitCast(DU(), v);
}
HWY_INLINE I ints_of(U v) {
    return hn::BitCast(DI(), v);
}

/// One corner of every triangle.
struct Corners {
    I x, y, z;
    U normal;

    /// nx, ny or nz.
    I component(std::size_t k) const {
        const U up = k == 0   ? hn::ShiftLeft<22>(normal)
                     : k == 1 ? hn::ShiftLeft<12>(normal)
                              : hn::ShiftLeft<2>(normal);
        return hn::ShiftRight<22>(ints_of(up));
    }
};

/// Doubles of all lanes: those of the lower lanes and of the upper ones.
struct Doubles {
    D lower, upper;
};

HWY_INLINE Doubles to_doubles(I v) {
    return {hn::PromoteTo(DD(), hn::LowerHalf(Half(), v)),
            hn::PromoteTo(DD(), hn::UpperHalf(Half(), v))};
}
HWY_INLINE Doubles product(const Doubles& a, const Doubles& b) {
    return {hn::Mul(a.lower, b.lower), hn::Mul(a.upper, b.upper)};
}
HWY_INLINE Doubles difference(const Doubles& a, const Doubles& b) {
    return {hn::Sub(a.lower, b.lower), hn::Sub(a.upper, b.upper)};
}

/// Numbers modulo 2^36: the 32 bits of an instruction word and 4 lower bits for grid steps.
struct Slope {
    U low;   ///< Bits 0..31.
    U high;  ///< Bits 4..35.
};

/// Returns the slope of one plane, like setup::Slopes: `numerator` times `scale`, a power of 2 over
/// det.
///
/// Unlike slopes of larger triangles, these slopes never need setup::exact_slopes(). The numerator
/// and the power of 2 make an N below 2^51. N / det has an error below 2^-52 of its value, which is
/// less than 1 / (2 det). An exact quotient that is not halfway between two integers is at least
/// 1 / (2 det) away from halfway, so it rounds correctly. A quotient can only be halfway if det has
/// more factors 2 than the power, which has 2^12 or more. Then the quotient is below 2^40, where
/// the definition rounds doubles, too.
HWY_INLINE Slope slope(const Doubles& numerator, const Doubles& scale) {
    const Doubles exact = product(numerator, scale);
    const D round = hn::Set(DD(), setup::to_nearest);
    const U lower = hn::BitCast(DU(), hn::Add(exact.lower, round));
    const U upper = hn::BitCast(DU(), hn::Add(exact.upper, round));
    const U low = hn::ConcatEven(DU(), upper, lower), above = hn::ConcatOdd(DU(), upper, lower);
    return {low, hn::Or(hn::ShiftRight<4>(low), hn::ShiftLeft<28>(above))};
}

/// One instruction of the triangle's shape: its word and three coefficients.
struct Instruction {
    U word, a, b, c;
};

/// Values that edges and planes share.
struct Setup {
    I dx1, dy1, dx2, dy2;  ///< From v0 to v1 and v2.
    I to_x, to_y;          ///< From v0 to the center of the region's first pixel.
};

/// Returns the edge from p along (dx, dy), like region_edge(). `to_x` and `to_y` lead from p to the
/// center of the region's first pixel.
HWY_INLINE Instruction edge(I dx, I dy, I to_x, I to_y) {
    constexpr int last = region_px - 1;
    const I zero = hn::Zero(DI());
    const I a = hn::Neg(dy), b = dx;
    const auto top_left = hn::Or(hn::Gt(a, zero), hn::And(hn::Eq(a, zero), hn::Gt(b, zero)));
    const I c16 = hn::Add(hn::Add(hn::Mul(a, to_x), hn::Mul(b, to_y)),
                          hn::IfThenElse(top_left, zero, splat(-1)));
    const I c = hn::ShiftRight<setup::shift>(c16);
    const I along_x = hn::Mul(a, splat(last)), along_y = hn::Mul(b, splat(last));
    const I high = hn::Add(c, hn::Add(hn::Max(along_x, zero), hn::Max(along_y, zero)));
    const I low = hn::Add(c, hn::Add(hn::Min(along_x, zero), hn::Min(along_y, zero)));
    const I farthest = hn::Max(high, hn::Not(low));
    const auto fits = [&](int width) HWY_ATTR {
        return hn::RebindMask(DU(), hn::Lt(farthest, splat(1 << (width - 1))));
    };
    const U wide = hn::IfThenElse(fits(24), word(shape::edge_word(24)), word(shape::edge_word(32)));
    return {hn::IfThenElse(fits(16), word(shape::edge_word(16)), wide), bits_of(a), bits_of(b),
            bits_of(c)};
}

/// Returns a plane in the region, like planes_of(). `at0` is the plane's value at v0.
template <int fraction>
HWY_INLINE Instruction plane(std::uint32_t instruction, const Slope& a, const Slope& b, I at0,
                             const Setup& s) {
    const auto below = [](const Slope& part, I factor) HWY_ATTR {
        return hn::Mul(ints_of(hn::And(part.low, word(15))), factor);
    };
    const U value = hn::Add(bits_of(hn::ShiftLeft<fraction>(at0)), word(1U << (fraction - 1)));
    const U whole = hn::Add(hn::Mul(a.high, bits_of(s.to_x)), hn::Mul(b.high, bits_of(s.to_y)));
    const I rest = hn::ShiftRight<setup::shift>(hn::Add(below(a, s.to_x), below(b, s.to_y)));
    return {word(instruction), a.low, b.low, hn::Add(value, hn::Add(whole, bits_of(rest)))};
}

/// Instructions 1 to 8 of every triangle, each with its coefficients.
inline constexpr std::size_t instruction_count = 8;
struct Block {
    alignas(64) std::uint32_t words[instruction_count][lanes][4];

    HWY_INLINE void put(std::size_t number, const Instruction& i) {
        hn::StoreInterleaved4(i.word, i.a, i.b, i.c, DU(), &words[number][0][0]);
    }
};

HWY_INLINE void put_edges(const Setup& s, Block& out) {
    out.put(0, edge(s.dx1, s.dy1, s.to_x, s.to_y));
    out.put(1, edge(hn::Sub(s.dx2, s.dx1), hn::Sub(s.dy2, s.dy1), hn::Sub(s.to_x, s.dx1),
                    hn::Sub(s.to_y, s.dy1)));
    out.put(2,
            edge(hn::Neg(s.dx2), hn::Neg(s.dy2), hn::Sub(s.to_x, s.dx2), hn::Sub(s.to_y, s.dy2)));
}

HWY_INLINE void put_planes(const Corners& v0, const Corners& v1, const Corners& v2, const Setup& s,
                           Block& out) {
    const Doubles det = to_doubles(hn::Sub(hn::Mul(s.dx1, s.dy2), hn::Mul(s.dx2, s.dy1)));
    const D one = hn::Set(DD(), 1.0);
    const Doubles inverse{hn::Div(one, det.lower), hn::Div(one, det.upper)};
    const auto scaled = [&](unsigned fraction) HWY_ATTR {
        const D scale = hn::Set(DD(), static_cast<double>(1U << (setup::shift + fraction)));
        return Doubles{hn::Mul(inverse.lower, scale), hn::Mul(inverse.upper, scale)};
    };

    // Products of depths exceed 32 bits; doubles represent them exactly.
    const Doubles z1 = to_doubles(hn::Sub(v1.z, v0.z)), z2 = to_doubles(hn::Sub(v2.z, v0.z));
    const Doubles z_scale = scaled(isa::region::z_fraction_bits);
    const Slope za =
        slope(difference(product(z1, to_doubles(s.dy2)), product(z2, to_doubles(s.dy1))), z_scale);
    const Slope zb =
        slope(difference(product(z2, to_doubles(s.dx1)), product(z1, to_doubles(s.dx2))), z_scale);
    Instruction z = plane<isa::region::z_fraction_bits>(shape::z_test_word, za, zb, v0.z, s);
    out.put(3, z);
    z.word = word(shape::z_store_word);
    out.put(4, z);

    const Doubles n_scale = scaled(isa::region::normal_fraction_bits);
    for (std::size_t k = 0; k < 3; ++k) {
        const I n0 = v0.component(k);
        const I n1 = hn::Sub(v1.component(k), n0), n2 = hn::Sub(v2.component(k), n0);
        const Slope a = slope(to_doubles(hn::Sub(hn::Mul(n1, s.dy2), hn::Mul(n2, s.dy1))), n_scale);
        const Slope b = slope(to_doubles(hn::Sub(hn::Mul(n2, s.dx1), hn::Mul(n1, s.dx2))), n_scale);
        out.put(5 + k,
                plane<isa::region::normal_fraction_bits>(shape::normal_words[k], a, b, n0, s));
    }
}

/// The corners of some triangles, side by side.
struct Batch {
    static constexpr std::size_t size = 64;
    alignas(64) std::array<std::array<GridVertex, size>, 3> corners;

    HWY_INLINE Corners load(std::size_t corner, std::size_t first) const {
        Corners c;
        I normal;
        hn::LoadInterleaved4(DI(), &corners[corner][first].x, c.x, c.y, c.z, normal);
        c.normal = bits_of(normal);
        return c;
    }
};

/// Sets up `lanes` triangles of the batch.
HWY_INLINE void set_up_some(const Batch& batch, std::size_t first, RegionPlace place, Block& out) {
    const Corners v0 = batch.load(0, first), v1 = batch.load(1, first), v2 = batch.load(2, first);
    const Setup s{hn::Sub(v1.x, v0.x),
                  hn::Sub(v1.y, v0.y),
                  hn::Sub(v2.x, v0.x),
                  hn::Sub(v2.y, v0.y),
                  hn::Sub(splat(place.x0_px * subpixels + setup::half), v0.x),
                  hn::Sub(splat(place.y0_px * subpixels + setup::half), v0.y)};
    put_edges(s, out);
    put_planes(v0, v1, v2, s, out);
}

HWY_INLINE void write_one(const Block& block, std::size_t lane, std::uint32_t surface_word,
                          std::uint32_t* words) {
    static_assert(shape::at_edge[0] == 1 && shape::at_surface == 1 + 4 * instruction_count);
    words[shape::at_enable] = shape::enable_word;
    for (std::size_t i = 0; i < instruction_count; ++i) {
        std::memcpy(words + 1 + 4 * i, block.words[i][lane], sizeof block.words[i][lane]);
    }
    words[shape::at_surface] = surface_word;
}

void set_up_all(std::span<const NamedTriangle> triangles, std::span<const GridVertex> corners,
                RegionPlace place, std::uint32_t* words) {
    Batch batch;
    Block block;
    for (std::size_t first = 0; first < triangles.size(); first += Batch::size) {
        const std::size_t count = std::min(triangles.size() - first, Batch::size);
        const std::size_t filled = (count + lanes - 1) / lanes * lanes;
        for (std::size_t i = 0; i < filled; ++i) {
            // The last triangle pads the last vector.
            const NamedTriangle& t = triangles[first + std::min(i, count - 1)];
            batch.corners[0][i] = corners[t.v0];
            batch.corners[1][i] = corners[t.v1];
            batch.corners[2][i] = corners[t.v2];
        }
        for (std::size_t i = 0; i < count; i += lanes) {
            set_up_some(batch, i, place, block);
            for (std::size_t k = i; k < std::min(i + lanes, count); ++k) {
                write_one(block, k - i, triangles[first + k].surface_word, words);
                words += shape::word_count;
            }
        }
    }
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::gp {

void set_up_triangles(std::span<const NamedTriangle> triangles, std::span<const GridVertex> corners,
                      RegionPlace place, std::uint32_t* words, VectorTarget target) {
    PXPL5_PER_TARGET(set_up_all)[target](triangles, corners, place, words);
}

}  // namespace pxpl5::gp
#endif
