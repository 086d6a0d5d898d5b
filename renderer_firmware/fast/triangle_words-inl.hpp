// Reads triangle programs (isa/contract/triangle_shape.hpp) in vectors: recognition and bounding
// boxes. Included by triangle.cpp behind hwy/foreach_target.h, which requires the toggling include
// guard.
#if defined(PXPL5_FAST_TRIANGLE_WORDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PXPL5_FAST_TRIANGLE_WORDS_INL
#undef PXPL5_FAST_TRIANGLE_WORDS_INL
#else
#define PXPL5_FAST_TRIANGLE_WORDS_INL
#endif

#include <cmath>

#include "isa/contract/triangle_shape.hpp"
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

namespace shape = isa::triangle;

inline constexpr std::uint32_t surface_bits = 0xFF;
inline constexpr std::uint32_t width_bits = 0xFF;
inline constexpr int last_px = region_px - 1;

/// Number of triangles that are read together.
inline constexpr std::size_t batch_size = lanes;

/// The 34 words of a triangle, with names for its three edges. The words are not copied.
struct Triangle {
    const std::uint32_t* words;

    const std::uint32_t* edge(std::size_t k) const { return words + shape::at_edge[k] + 1; }
    const std::uint32_t* z() const { return words + shape::at_z_test + 1; }
    const std::uint32_t* normal(std::size_t k) const { return words + shape::at_normal[k] + 1; }
    std::uint32_t edge_width(std::size_t k) const { return words[shape::at_edge[k]] & width_bits; }
    std::uint32_t surface() const { return words[shape::at_surface] >> 8 & surface_bits; }
};

/// Up to batch_size consecutive triangles.
struct Batch {
    const std::uint32_t* words;
    std::size_t count;

    Triangle operator[](std::size_t i) const { return {words + i * shape::word_count}; }
};

// ---- recognition: isa::triangle::matches(), by vectors

/// The required words of a triangle where `mask` is set. Edge widths are checked separately.
struct Shape {
    alignas(64) std::uint32_t mask[shape::word_count] = {};
    alignas(64) std::uint32_t bits[shape::word_count] = {};

    constexpr Shape() {
        put(shape::at_enable, shape::enable_word, ~0U);
        put(shape::at_z_test, shape::z_test_word, ~0U);
        put(shape::at_z_store, shape::z_store_word, ~0U);
        put(shape::at_surface, shape::surface_word(0), ~(surface_bits << 8));
        for (std::size_t k = 0; k < 3; ++k) {
            put(shape::at_edge[k], shape::edge_word(0), ~width_bits);
            put(shape::at_normal[k], shape::normal_words[k], ~0U);
        }
    }
    constexpr void put(std::size_t at, std::uint32_t word, std::uint32_t where) {
        mask[at] = where;
        bits[at] = word;
    }
};
inline constexpr Shape triangle_shape;

/// Compares `words` with a triangle. Returns 0 in all lanes if they are equal; ignores the widths
/// of the edges.
HWY_INLINE V mismatch(const std::uint32_t* words) {
    const D d;
    // The z test and the z store must have the same plane.
    const V planes = hn::Xor(hn::LoadU(d, words + shape::at_z_test + 1),
                             hn::LoadU(d, words + shape::at_z_store + 1));
    V wrong = hn::IfThenElseZero(hn::FirstN(d, 3), planes);
    const auto compare = [&](std::size_t i) PXPL5_BODY {
        const V word = hn::And(hn::LoadU(d, words + i), hn::LoadU(d, triangle_shape.mask + i));
        wrong = hn::Or(wrong, hn::Xor(word, hn::LoadU(d, triangle_shape.bits + i)));
    };
    for (std::size_t i = 0; i + lanes <= shape::word_count; i += lanes) {
        compare(i);
    }
    compare(shape::word_count - lanes);  // The remaining words; some are compared twice.
    return wrong;
}
static_assert(shape::at_z_store + 1 + lanes <= shape::word_count);

/// Returns the triangles at the beginning of `words`, at most `most`; does not check edge widths.
HWY_INLINE Batch read_batch(const std::uint32_t* words, std::size_t most) {
    const Batch batch{words, most};
    V wrong = hn::Zero(D());
    for (std::size_t i = 0; i < most; ++i) {
        wrong = hn::Or(wrong, mismatch(batch[i].words));
    }
    if (hn::AllTrue(D(), hn::Eq(wrong, hn::Zero(D())))) {
        return batch;
    }
    std::size_t count = 0;
    while (hn::AllTrue(D(), hn::Eq(mismatch(batch[count].words), hn::Zero(D())))) {
        ++count;
    }
    return {words, count};
}

// ---- bounding boxes

/// Pixels that may be inside; empty if x0 > x1 or y0 > y1.
struct Box {
    int x0 = 0, x1 = last_px, y0 = 0, y1 = last_px;
};

/// The boxes of a batch, one triangle per lane.
struct Boxes {
    HWY_ALIGN std::int32_t x0[lanes], x1[lanes], y0[lanes], y1[lanes];
    std::uint32_t known;  ///< One bit per triangle: set if its box is valid.

    Box operator[](std::size_t i) const { return {x0[i], x1[i], y0[i], y1[i]}; }
};

// Three half planes bound a triangle exactly if the weights of the intersections of their lines
// have the same sign. The corners are then the intersections (x, y) / weight. For lines p and q:
//     weight = pa qb - qa pb    x = pb qc - qb pc    y = pc qa - qc pa

using DF = hn::RebindToFloat<D>;
using VI = hn::Vec<DI>;
using VF = hn::Vec<DF>;

/// One edge of every triangle of a batch: A x + B y + C, and the width of its sign test.
struct Edges {
    VI a, b, c, width;
};

/// Returns edge k of the triangles of `batch`; unused lanes repeat the last triangle.
HWY_INLINE Edges gather_edges(const Batch& batch, std::size_t k) {
    const DI i;
    const VI last = hn::Set(i, static_cast<std::int32_t>(batch.count - 1));
    const VI at = hn::Mul(hn::Min(hn::Iota(i, 0), last),
                          hn::Set(i, static_cast<std::int32_t>(shape::word_count)));
    // int32_t and uint32_t may alias.
    const auto* words = reinterpret_cast<const std::int32_t*>(batch.words) + shape::at_edge[k];
    return {hn::GatherIndex(i, words + 1, at), hn::GatherIndex(i, words + 2, at),
            hn::GatherIndex(i, words + 3, at),
            hn::And(hn::GatherIndex(i, words, at), hn::Set(i, width_bits))};
}

/// Coefficients below this limit are exact as floats, and sums of magnitudes do not overflow.
inline constexpr std::int32_t max_small = 1 << 20;

/// True where all coefficients are small, the width is one of the shape's, and the edge's values
/// fit the width in the whole region. Then bit n-1 is the sign.
HWY_INLINE hn::Mask<DI> is_small_and_fits(const Edges& e) {
    const DI i;
    const VI zero = hn::Zero(i);
    // Bitwise, because the magnitude of the least number is still negative.
    const VI upper =
        hn::And(hn::Or(hn::Or(hn::Abs(e.a), hn::Abs(e.b)), hn::Abs(e.c)), hn::Set(i, -max_small));
    // An edge's values are between the values at the corners of the region.
    const VI along_x = hn::Mul(e.a, hn::Set(i, last_px)),
             along_y = hn::Mul(e.b, hn::Set(i, last_px));
    const VI high = hn::Add(e.c, hn::Add(hn::Max(along_x, zero), hn::Max(along_y, zero)));
    const VI low = hn::Add(e.c, hn::Add(hn::Min(along_x, zero), hn::Min(along_y, zero)));
    // 2^(n-1), but 2^31 - 1 for 32, and 0 for a width outside the shape.
    const auto limit = [&](std::size_t k, std::int32_t value) PXPL5_BODY {
        const VI width = hn::Set(i, static_cast<std::int32_t>(shape::edge_widths[k]));
        return hn::IfThenElseZero(hn::Eq(e.width, width), hn::Set(i, value));
    };
    static_assert(shape::edge_widths == std::array{16U, 24U, 32U});
    const VI limits = hn::Or(hn::Or(limit(0, 1 << 15), limit(1, 1 << 23)), limit(2, INT32_MAX));
    return hn::And(hn::Eq(upper, zero), hn::Lt(hn::Max(high, hn::Not(low)), limits));
}

/// Returns p * q - r * s, and the larger magnitude of the two products.
struct Cross {
    VF value, most;
};
HWY_INLINE Cross cross(VF p, VF q, VF r, VF s) {
    const VF pq = hn::Mul(p, q), rs = hn::Mul(r, s);
    return {hn::Sub(pq, rs), hn::Max(hn::Abs(pq), hn::Abs(rs))};
}

/// The intersection of two edges, the error bound of its position, and the sign of its weight.
struct Meetings {
    VF x, y, margin, weight;
};
HWY_INLINE Meetings meet(const Edges& p, const Edges& q) {
    const DF f;
    const VF pa = hn::ConvertTo(f, p.a), pb = hn::ConvertTo(f, p.b), pc = hn::ConvertTo(f, p.c);
    const VF qa = hn::ConvertTo(f, q.a), qb = hn::ConvertTo(f, q.b), qc = hn::ConvertTo(f, q.c);
    const Cross weight = cross(pa, qb, qa, pb);
    const Cross x_weighted = cross(pb, qc, qb, pc), y_weighted = cross(pc, qa, qc, pa);
    const VF inverse = hn::Div(hn::Set(f, 1.0F), weight.value);
    constexpr float low = -2, high = last_px + 2;
    // The error of a crossed product is at most 2^-22 of its larger part; that of an inverse and
    // its product is 2^-23 of the value. For a position in -2..129 the error is below this, twice:
    const VF most =
        hn::Add(hn::Max(x_weighted.most, y_weighted.most), hn::Mul(weight.most, hn::Set(f, high)));
    const VF scale = hn::Mul(hn::Abs(inverse), hn::Set(f, 1.0F / (1 << 20)));
    const VF margin = hn::Add(hn::Mul(most, scale), hn::Set(f, 1.0F / 512));
    const auto cut = [&](VF v) PXPL5_BODY {
        return hn::Min(hn::Max(v, hn::Set(f, low)), hn::Set(f, high));
    };
    return {cut(hn::Mul(x_weighted.value, inverse)), cut(hn::Mul(y_weighted.value, inverse)),
            margin, weight.value};
}

/// Stores the pixels between the least and the greatest of three positions.
HWY_INLINE void store_ends(const VF (&places)[3], const VF (&margins)[3], hn::Mask<DF> bounded,
                           std::int32_t* first, std::int32_t* last) {
    const DF f;
    const DI i;
    VF least = hn::Sub(places[0], margins[0]), most = hn::Add(places[0], margins[0]);
    for (std::size_t k = 1; k < 3; ++k) {
        least = hn::Min(least, hn::Sub(places[k], margins[k]));
        most = hn::Max(most, hn::Add(places[k], margins[k]));
    }
    const VF whole = hn::Set(f, last_px);
    least = hn::IfThenElseZero(bounded, hn::Max(hn::Ceil(least), hn::Zero(f)));
    most = hn::IfThenElse(bounded, hn::Min(hn::Floor(most), whole), whole);
    hn::Store(hn::ConvertTo(i, least), i, first);
    hn::Store(hn::ConvertTo(i, most), i, last);
}

/// Returns the boxes of the triangles with small coefficients whose corners floats locate within a
/// pixel. The box is the whole region if the edges do not bound a triangle.
HWY_INLINE void find_boxes(const Batch& batch, Boxes& boxes) {
    const DF f;
    const Edges e[3] = {gather_edges(batch, 0), gather_edges(batch, 1), gather_edges(batch, 2)};
    const Meetings m[3] = {meet(e[0], e[1]), meet(e[1], e[2]), meet(e[2], e[0])};
    const VF zero = hn::Zero(f);
    const auto bounded =
        hn::Or(hn::And(hn::And(hn::Gt(m[0].weight, zero), hn::Gt(m[1].weight, zero)),
                       hn::Gt(m[2].weight, zero)),
               hn::And(hn::And(hn::Lt(m[0].weight, zero), hn::Lt(m[1].weight, zero)),
                       hn::Lt(m[2].weight, zero)));
    const VF margins[3] = {m[0].margin, m[1].margin, m[2].margin};
    store_ends({m[0].x, m[1].x, m[2].x}, margins, bounded, boxes.x0, boxes.x1);
    store_ends({m[0].y, m[1].y, m[2].y}, margins, bounded, boxes.y0, boxes.y1);

    const auto fits =
        hn::And(hn::And(is_small_and_fits(e[0]), is_small_and_fits(e[1])), is_small_and_fits(e[2]));
    const VF margin = hn::Max(hn::Max(margins[0], margins[1]), margins[2]);
    const auto told = hn::Or(hn::Lt(margin, hn::Set(f, 0.5F)), hn::Not(bounded));
    boxes.known = bits_of(hn::And(hn::RebindMask(D(), fits), hn::RebindMask(D(), told)));
}

/// The intersection of the lines of two edges, as a weighted point.
struct Meeting {
    double weight, x, y;
};
HWY_INLINE Meeting meet(const std::int32_t* p, const std::int32_t* q) {
    const double pa = p[0], pb = p[1], pc = p[2], qa = q[0], qb = q[1], qc = q[2];
    return {pa * qb - qa * pb, pb * qc - qb * pc, pc * qa - qc * pa};
}

/// Edges with a larger A or B give no bounding box: the products would be inexact.
inline constexpr std::int64_t max_box_slope = std::int64_t{1} << 21;

inline Box box_in_doubles(const std::int32_t (*edges)[3]) {
    const Meeting m[3] = {meet(edges[0], edges[1]), meet(edges[1], edges[2]),
                          meet(edges[2], edges[0])};
    const bool positive = m[0].weight > 0 && m[1].weight > 0 && m[2].weight > 0;
    const bool negative = m[0].weight < 0 && m[1].weight < 0 && m[2].weight < 0;
    if (!positive && !negative) {
        return {};
    }
    constexpr double margin = 1e-6, low = -2, high = last_px + 2;
    double x0 = high, x1 = low, y0 = high, y1 = low;
    for (const Meeting& corner : m) {
        const double x = HWY_MAX(low, HWY_MIN(high, corner.x / corner.weight));
        const double y = HWY_MAX(low, HWY_MIN(high, corner.y / corner.weight));
        x0 = HWY_MIN(x0, x), x1 = HWY_MAX(x1, x);
        y0 = HWY_MIN(y0, y), y1 = HWY_MAX(y1, y);
    }
    const auto first = [](double v) { return HWY_MAX(static_cast<int>(std::ceil(v - margin)), 0); };
    const auto last = [](double v) {
        return HWY_MIN(static_cast<int>(std::floor(v + margin)), last_px);
    };
    return {first(x0), last(x1), first(y0), last(y1)};
}

/// Computes the bounding box for any coefficients. Returns false if the width of an edge is not one
/// of the shape's, or an edge could exceed its n bits in the region. Bit n-1 is then not the sign,
/// and the instructions must run one by one.
HWY_NOINLINE inline bool find_large_box(const Triangle& t, Box& box) {
    std::int32_t edges[3][3];
    std::int64_t slope = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        std::memcpy(edges[k], t.edge(k), sizeof edges[k]);
        const std::int64_t a = edges[k][0], b = edges[k][1], c = edges[k][2];
        const auto end = [&](std::int64_t m, std::int64_t n) {
            return HWY_MAX(m * last_px, 0) + HWY_MAX(n * last_px, 0);
        };
        const std::int64_t most = HWY_MAX(c + end(a, b), ~(c - end(-a, -b)));
        const std::uint32_t n = t.edge_width(k);
        const bool known =
            n == shape::edge_widths[0] || n == shape::edge_widths[1] || n == shape::edge_widths[2];
        if (!known || most >= std::int64_t{1} << (n - 1)) {
            return false;
        }
        slope = HWY_MAX(slope, HWY_MAX(std::llabs(a), std::llabs(b)));
    }
    box = slope < max_box_slope ? box_in_doubles(edges) : Box();
    return true;
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // PXPL5_FAST_TRIANGLE_WORDS_INL
