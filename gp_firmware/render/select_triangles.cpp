#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gp_firmware/render/select_triangles.cpp"
#include <hwy/foreach_target.h>
// highway.h must follow foreach_target.h, which compiles this file once per target.
#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>

#include "gp_firmware/geometry/lanes-inl.hpp"
#include "gp_firmware/render/select_triangles.hpp"
#include "gp_firmware/render/set_up_triangles.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

using M = hn::Mask<DI>;
static_assert(Selection::size % lanes == 0);

inline constexpr int half = subpixels / 2;
inline constexpr int grid_bits = isa::region::subpixel_bits;

HWY_INLINE M at_most(I a, I b) {
    return hn::Not(hn::Gt(a, b));
}

struct Points {
    I x, y;
};

/// Gathers the vertices' grid positions, x and y as one 64-bit number.
HWY_INLINE Points points_at(const GridVertex* vertices, I index) {
    using Pairs = hn::RepartitionToWide<DI>;
    static_assert(offsetof(GridVertex, y) == 4 && sizeof(GridVertex) == 2 * sizeof(std::int64_t));
    const auto* base = reinterpret_cast<const std::int64_t*>(vertices);
    const auto pairs = [base](auto half_of_index) HWY_ATTR {
        const auto at = hn::ShiftLeft<1>(hn::PromoteTo(Pairs(), half_of_index));
        return hn::BitCast(DI(), hn::GatherIndex(Pairs(), base, at));
    };
    const hn::Half<DI> half_lanes;
    const I lower = pairs(hn::LowerHalf(half_lanes, index));
    const I upper = pairs(hn::UpperHalf(half_lanes, index));
    return {hn::ConcatEven(DI(), upper, lower), hn::ConcatOdd(DI(), upper, lower)};
}

struct Range {
    I low, high;
};
HWY_INLINE Range range(I a, I b, I c) {
    return {hn::Min(a, hn::Min(b, c)), hn::Max(a, hn::Max(b, c))};
}

/// Returns the picture's pixels whose centers lie in the range, like pixel_box().
HWY_INLINE Range pixels_in(const Range& r, int size_px) {
    return {hn::Max(hn::ShiftRight<grid_bits>(hn::Add(r.low, splat(half - 1))), hn::Zero(DI())),
            hn::Min(hn::ShiftRight<grid_bits>(hn::Sub(r.high, splat(half))), splat(size_px - 1))};
}

/// 16 times an edge's value at a pixel center, with its sign, and the slopes per pixel.
struct EdgeHere {
    I value, a, b;
};

/// Returns the edge from p to q at the center of the first pixel of the triangle's box.
HWY_INLINE EdgeHere edge_at(const Points& p, const Points& q, const Range& x_px,
                            const Range& y_px) {
    const I zero = hn::Zero(DI());
    const I a = hn::Sub(p.y, q.y), b = hn::Sub(q.x, p.x);
    const auto top_left = hn::Or(hn::Gt(a, zero), hn::And(hn::Eq(a, zero), hn::Gt(b, zero)));
    const I x = hn::Add(hn::ShiftLeft<grid_bits>(x_px.low), splat(half));
    const I y = hn::Add(hn::ShiftLeft<grid_bits>(y_px.low), splat(half));
    const I value = hn::Add(hn::Add(hn::Mul(a, hn::Sub(x, p.x)), hn::Mul(b, hn::Sub(y, p.y))),
                            hn::IfThenElse(top_left, zero, splat(-1)));
    return {value, hn::ShiftLeft<grid_bits>(a), hn::ShiftLeft<grid_bits>(b)};
}

/// Returns the edge's value dx and dy pixels further.
HWY_INLINE I moved(const EdgeHere& e, I dx, I dy) {
    return hn::Add(e.value, hn::Add(hn::Mul(e.a, dx), hn::Mul(e.b, dy)));
}

HWY_INLINE M none_negative(I a, I b, I c) {
    return at_most(hn::Zero(DI()), hn::Or(a, hn::Or(b, c)));
}

/// Returns whether the triangle covers a pixel center of its box of `width` x `height` pixels, 1 to
/// searched_px in all.
HWY_INLINE M covers_a_center(const EdgeHere (&e)[3], I width, I height) {
    static_assert(searched_px == 4);
    const I one = splat(1), two = splat(2), three = splat(3);
    const M wide_2 = hn::Gt(width, one), wide_3 = hn::Gt(width, two);
    const M is_2 = hn::Eq(width, two), is_4 = hn::Gt(width, three);
    const I area = hn::Mul(width, height);
    const auto covered = [&](I dx, I dy) HWY_ATTR {
        return none_negative(moved(e[0], dx, dy), moved(e[1], dx, dy), moved(e[2], dx, dy));
    };
    // The second, third and fourth pixel of 1 x n, 2 x n, 3 x 1 and 4 x 1.
    const I x1 = hn::IfThenElseZero(wide_2, one), y1 = hn::Sub(one, x1);
    const I x2 = hn::IfThenElseZero(wide_3, two);
    const I y2 = hn::IfThenZeroElse(wide_3, hn::IfThenElse(is_2, one, two));
    const I x3 = hn::IfThenElse(is_4, three, hn::IfThenElseZero(is_2, one));
    const I y3 = hn::IfThenZeroElse(is_4, hn::IfThenElse(is_2, one, three));
    return hn::Or(hn::Or(none_negative(e[0].value, e[1].value, e[2].value),
                         hn::And(hn::Gt(area, one), covered(x1, y1))),
                  hn::Or(hn::And(hn::Gt(area, two), covered(x2, y2)),
                         hn::And(hn::Gt(area, three), covered(x3, y3))));
}

/// Returns whether any pixel of the region of (x_px.low, y_px.low) is inside the edge.
HWY_INLINE M enters(const EdgeHere& e, const Range& x_px, const Range& y_px) {
    constexpr int last = region_px - 1;
    const I x_in = hn::And(x_px.low, splat(last)), y_in = hn::And(y_px.low, splat(last));
    const I zero = hn::Zero(DI());
    // The edge has its highest value at a corner of the region.
    const I dx = hn::IfThenElse(hn::Gt(e.a, zero), hn::Sub(splat(last), x_in), hn::Neg(x_in));
    const I dy = hn::IfThenElse(hn::Gt(e.b, zero), hn::Sub(splat(last), y_in), hn::Neg(y_in));
    return at_most(zero, moved(e, dx, dy));
}

/// The values or points of the three corners of each triangle.
template <class T>
struct Three {
    T a, b, c;
};

/// Triangles inside all planes, and triangles that cross planes. Triangles that are wholly outside
/// of one plane are in neither.
struct Clipping {
    M inside, crossing;
};

HWY_INLINE Clipping clipping_of(const std::uint32_t* outside, const Three<I>& index) {
    const auto bits = [&](I i) HWY_ATTR {
        return hn::GatherIndex(DI(), reinterpret_cast<const std::int32_t*>(outside), i);
    };
    const I a = bits(index.a), b = bits(index.b), c = bits(index.c), zero = hn::Zero(DI());
    const M inside = hn::Eq(hn::Or(a, hn::Or(b, c)), zero);
    const M apart = hn::Eq(hn::And(a, hn::And(b, c)), zero);
    return {inside, hn::AndNot(inside, apart)};
}

/// Lane numbers below `count`.
HWY_INLINE M first_lanes(std::size_t count) {
    return hn::Lt(hn::Iota(DI(), 0), splat(static_cast<int>(count)));
}

/// The orders of corners in which determinants are positive.
struct Winding {
    M positive;  ///< The corners already have that order.
    M shown;     ///< The triangle has an area and is not culled.

    /// Returns the value for the corner order that has a positive determinant.
    HWY_INLINE I pick(I if_positive, I if_not) const {
        return hn::IfThenElse(positive, if_positive, if_not);
    }
};

HWY_INLINE Winding winding_of(const Three<Points>& p, bool cull_back) {
    const I det = hn::Sub(hn::Mul(hn::Sub(p.b.x, p.a.x), hn::Sub(p.c.y, p.a.y)),
                          hn::Mul(hn::Sub(p.c.x, p.a.x), hn::Sub(p.b.y, p.a.y)));
    const I zero = hn::Zero(DI());
    // Triangles counter-clockwise to the eye have a negative determinant, because y points down.
    return {hn::Gt(det, zero), cull_back ? hn::Lt(det, zero) : hn::Not(hn::Eq(det, zero))};
}

/// The region of the first pixel of a box.
struct FirstRegion {
    I number;
    M is_only;  ///< The whole box lies in the region.
};

HWY_INLINE FirstRegion first_region(const RegionGrid& grid, const Range& x_px, const Range& y_px) {
    const I column = hn::ShiftRight<region_bits>(x_px.low);
    const I row = hn::ShiftRight<region_bits>(y_px.low);
    return {hn::Add(hn::Add(column, splat(grid.first_region)), hn::Mul(row, splat(grid.columns))),
            hn::And(hn::Eq(column, hn::ShiftRight<region_bits>(x_px.high)),
                    hn::Eq(row, hn::ShiftRight<region_bits>(y_px.high)))};
}

/// Selects `lanes` triangles. Bit i of the result belongs to triangle i.
HWY_INLINE std::uint64_t select_some(const ScreenSlab& slab, const RegionGrid& grid,
                                     const std::uint32_t* indices, M given, std::size_t at,
                                     Selection& out) {
    Three<I> index;
    hn::LoadInterleaved3(DI(), reinterpret_cast<const std::int32_t*>(indices), index.a, index.b,
                         index.c);
    const Three<Points> p{points_at(slab.vertices, index.a), points_at(slab.vertices, index.b),
                          points_at(slab.vertices, index.c)};
    const Range xs = range(p.a.x, p.b.x, p.c.x), ys = range(p.a.y, p.b.y, p.c.y);
    const Range x_px = pixels_in(xs, grid.width_px), y_px = pixels_in(ys, grid.height_px);
    M in_picture =
        hn::And(given, hn::And(at_most(x_px.low, x_px.high), at_most(y_px.low, y_px.high)));
    M by_itself = hn::Gt(hn::Zero(DI()), hn::Zero(DI()));
    if (slab.outside != nullptr) {
        const Clipping clipping = clipping_of(slab.outside, index);
        in_picture = hn::And(in_picture, clipping.inside);
        by_itself = hn::And(given, clipping.crossing);
    }
    if (hn::AllFalse(DI(), hn::Or(in_picture, by_itself))) {
        return 0;
    }
    const I limit = splat(max_extent);
    const M fits =
        hn::And(hn::Lt(hn::Sub(xs.high, xs.low), limit), hn::Lt(hn::Sub(ys.high, ys.low), limit));
    by_itself = hn::Or(by_itself, hn::AndNot(fits, in_picture));

    // From here on, triangles that do not fit may overflow. Their results are not used.
    const Winding winding = winding_of(p, slab.cull_back);
    const Points v1{winding.pick(p.b.x, p.c.x), winding.pick(p.b.y, p.c.y)};
    const Points v2{winding.pick(p.c.x, p.b.x), winding.pick(p.c.y, p.b.y)};
    const EdgeHere edges[3] = {edge_at(p.a, v1, x_px, y_px), edge_at(v1, v2, x_px, y_px),
                               edge_at(v2, p.a, x_px, y_px)};
    const I width = hn::Add(hn::Sub(x_px.high, x_px.low), splat(1));
    const I height = hn::Add(hn::Sub(y_px.high, y_px.low), splat(1));
    const M large = hn::Gt(hn::Mul(width, height), splat(searched_px));
    const M seen = hn::And(hn::And(hn::And(in_picture, fits), winding.shown),
                           hn::Or(large, covers_a_center(edges, width, height)));
    const FirstRegion region = first_region(grid, x_px, y_px);
    const M touched = hn::And(enters(edges[0], x_px, y_px),
                              hn::And(enters(edges[1], x_px, y_px), enters(edges[2], x_px, y_px)));

    const auto special = [](std::uint32_t value)
                             HWY_ATTR { return splat(static_cast<int>(value)); };
    const I place = hn::IfThenElse(
        by_itself, special(Selection::by_itself),
        hn::IfThenElse(region.is_only, region.number, special(Selection::many_regions)));
    const I first = splat(static_cast<int>(slab.first_corner));
    hn::StoreU(place, DI(), reinterpret_cast<std::int32_t*>(&out.regions[at]));
    hn::StoreInterleaved4(hn::Add(index.a, first), hn::Add(winding.pick(index.b, index.c), first),
                          hn::Add(winding.pick(index.c, index.b), first),
                          splat(static_cast<int>(slab.surface_word)), DI(),
                          reinterpret_cast<std::int32_t*>(&out.triangles[at]));
    const M chosen = hn::Or(by_itself, hn::And(seen, hn::Or(touched, hn::Not(region.is_only))));
    std::uint64_t bits = 0;
    hn::StoreMaskBits(DI(), chosen, reinterpret_cast<std::uint8_t*>(&bits));
    return bits;
}

void select(const ScreenSlab& slab, const RegionGrid& grid, std::size_t first, Selection& out) {
    const std::size_t count = std::min(slab.indices.size() / 3 - first, Selection::size);
    const std::uint32_t* indices = slab.indices.data() + 3 * first;
    out.chosen = 0;
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        out.chosen |= select_some(slab, grid, indices + 3 * i, first_lanes(lanes), i, out) << i;
    }
    if (i < count) {
        std::array<std::uint32_t, 3 * lanes> last{};
        std::copy(indices + 3 * i, indices + 3 * count, last.begin());
        out.chosen |= select_some(slab, grid, last.data(), first_lanes(count - i), i, out) << i;
    }
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::gp {

SelectTriangles select_triangles(VectorTarget target) {
    return PXPL5_PER_TARGET(select)[target];
}

}  // namespace pxpl5::gp
#endif
