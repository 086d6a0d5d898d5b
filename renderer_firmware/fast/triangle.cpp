// Triangles, fast: the ten instructions of isa/triangle_shape.hpp as one pass over the vectors of
// the triangle's bounding box.
//
// Nobody can see the enables of a triangle that another one follows, whose SETENABS overwrites
// them. So they are noted while a triangle is drawn, and written for the last one of a run only.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/triangle.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles what follows once per target.
#include <cmath>

#include "isa/triangle_shape.hpp"
#include "renderer_firmware/fast/vector-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

namespace shape = isa::triangle;
namespace layout = isa::region;
static_assert(layout::surface.address == 0 && layout::surface.width == 8 &&
                  layout::z.address == 8 && layout::z.width == 24 && layout::z_fraction_bits == 8,
              "column 0 is z above the surface number, and Q of z is the column itself");
static_assert(layout::normal_x.address == 32 && layout::normal_y.address == 42 &&
                  layout::normal_z.address == 52 && layout::normal_z.width == 10 &&
                  layout::normal_x.width + layout::normal_fraction_bits <= 32,
              "column 1 is the normal, and its planes fit 32-bit lanes");

inline constexpr std::uint32_t surface_bits = 0xFF;
inline constexpr std::uint32_t normal_mask = (1U << 10) - 1;
inline constexpr std::uint32_t beside_normal = 3U << 30;  ///< Bits 62 and 63 belong to nobody.
inline constexpr int last_px = layout::size_px - 1;

/// A triangle's 34 words and its three edges by name. Coefficients are used where they lie.
struct Triangle {
    const std::uint32_t* words;

    const std::uint32_t* edge(std::size_t k) const { return words + shape::at_edge[k] + 1; }
    const std::uint32_t* z() const { return words + shape::at_z_test + 1; }
    const std::uint32_t* normal(std::size_t k) const { return words + shape::at_normal[k] + 1; }
    std::uint32_t edge_width(std::size_t k) const { return words[shape::at_edge[k]] & 0xFF; }
    std::uint32_t surface() const { return words[shape::at_surface] >> 8 & surface_bits; }
};

// ---- recognition: isa::triangle::matches(), by vectors

/// What the words of a triangle must be where `mask` is set. Edge widths are checked apart.
struct Shape {
    alignas(64) std::uint32_t mask[shape::word_count] = {};
    alignas(64) std::uint32_t bits[shape::word_count] = {};

    constexpr Shape() {
        put(shape::at_enable, shape::enable_word, ~0U);
        put(shape::at_z_test, shape::z_test_word, ~0U);
        put(shape::at_z_store, shape::z_store_word, ~0U);
        put(shape::at_surface, shape::surface_word(0), ~(surface_bits << 8));
        for (std::size_t k = 0; k < 3; ++k) {
            put(shape::at_edge[k], shape::edge_word(0), ~0xFFU);
            put(shape::at_normal[k], shape::normal_words[k], ~0U);
        }
    }
    constexpr void put(std::size_t at, std::uint32_t word, std::uint32_t where) {
        mask[at] = where;
        bits[at] = word;
    }
};
inline constexpr Shape triangle_shape;

/// True if `words` begins with a triangle, but for the widths of its edges.
HWY_INLINE bool has_shape(const std::uint32_t* words) {
    V wrong = hn::Zero(D());
    constexpr std::size_t whole = shape::word_count / lanes * lanes;
    for (std::size_t i = 0; i < whole; i += lanes) {
        const V word = hn::And(hn::LoadU(D(), words + i), hn::Load(D(), triangle_shape.mask + i));
        wrong = hn::Or(wrong, hn::Xor(word, hn::Load(D(), triangle_shape.bits + i)));
    }
    std::uint32_t rest = 0;
    for (std::size_t i = whole; i < shape::word_count; ++i) {
        rest |= (words[i] & triangle_shape.mask[i]) ^ triangle_shape.bits[i];
    }
    for (std::size_t k = 1; k <= 3; ++k) {
        rest |= words[shape::at_z_test + k] ^ words[shape::at_z_store + k];
    }
    return rest == 0 && bits_of(hn::Eq(wrong, hn::Zero(D()))) == all_lanes;
}

// ---- bounding box

/// Pixels that may lie inside; empty if x0 > x1 or y0 > y1. `ends` as x0, -x1, y0, -y1.
struct Box {
    HWY_ALIGN std::int32_t ends[4] = {0, -last_px, 0, -last_px};
    int x0() const { return ends[0]; }
    int x1() const { return -ends[1]; }
    int y0() const { return ends[2]; }
    int y1() const { return -ends[3]; }
};

// Three half planes bound a triangle exactly if the weights of the meetings of their lines have one
// sign; its corners are then the meetings (x, y) / weight. For lines p and q:
//     weight = pa qb - qa pb    x = pb qc - qb pc    y = pc qa - qc pa

using I4 = hn::FixedTag<std::int32_t, 4>;
using F4 = hn::FixedTag<float, 4>;
using VI4 = hn::Vec<I4>;
using VF4 = hn::Vec<F4>;

/// Four lines: instruction words and coefficients.
struct Lines {
    VI4 op, a, b, c;
};

/// Lines from the words `op A B C` of p, q, r, s, in this order of lanes.
HWY_INLINE Lines lines_at(VI4 p, VI4 q, VI4 r, VI4 s) {
    const I4 i;
    const VI4 pr_low = hn::InterleaveLower(i, p, r), qs_low = hn::InterleaveLower(i, q, s);
    const VI4 pr_high = hn::InterleaveUpper(i, p, r), qs_high = hn::InterleaveUpper(i, q, s);
    return {hn::InterleaveLower(i, pr_low, qs_low), hn::InterleaveUpper(i, pr_low, qs_low),
            hn::InterleaveLower(i, pr_high, qs_high), hn::InterleaveUpper(i, pr_high, qs_high)};
}

/// p * q - r * s, and the larger magnitude of the two products.
struct Cross {
    VF4 value, most;
};
HWY_INLINE Cross cross(VF4 p, VF4 q, VF4 r, VF4 s) {
    const VF4 pq = hn::Mul(p, q), rs = hn::Mul(r, s);
    return {hn::Sub(pq, rs), hn::Max(hn::Abs(pq), hn::Abs(rs))};
}

/// Coefficients below this are exact as floats, and sums of magnitudes do not overflow.
inline constexpr std::int32_t max_small = 1 << 20;

/// Fills in the box, which stays whole if the edges bound no triangle. Lanes are the three
/// meetings, the first one twice. False if floats cannot tell within a pixel; coefficients are
/// small.
HWY_INLINE bool box_in_floats(const Lines& p, const Lines& q, Box& box) {
    const F4 f;
    const VF4 pa = hn::ConvertTo(f, p.a), pb = hn::ConvertTo(f, p.b), pc = hn::ConvertTo(f, p.c);
    const VF4 qa = hn::ConvertTo(f, q.a), qb = hn::ConvertTo(f, q.b), qc = hn::ConvertTo(f, q.c);
    const Cross weight = cross(pa, qb, qa, pb);
    const VF4 zero = hn::Zero(f);
    if (!hn::AllTrue(f, hn::Gt(weight.value, zero)) &&
        !hn::AllTrue(f, hn::Lt(weight.value, zero))) {
        return true;
    }
    const Cross x_weighted = cross(pb, qc, qb, pc), y_weighted = cross(pc, qa, qc, pa);
    const VF4 inverse = hn::Div(hn::Set(f, 1.0F), weight.value);
    constexpr float low = -2, high = last_px + 2;
    // A crossed product is off by at most 2^-22 of its larger part, an inverse and its product
    // by 2^-23 of themselves. A place in -2..129 is then off by less than this, twice over:
    const VF4 most =
        hn::Add(hn::Max(x_weighted.most, y_weighted.most), hn::Mul(weight.most, hn::Set(f, high)));
    const VF4 scale = hn::Mul(hn::Abs(inverse), hn::Set(f, 1.0F / (1 << 20)));
    const VF4 margin = hn::Add(hn::Mul(most, scale), hn::Set(f, 1.0F / 512));
    if (!hn::AllTrue(f, hn::Lt(margin, hn::Set(f, 0.5F)))) {
        return false;
    }
    const auto cut = [&](VF4 v) PXPL5_BODY {
        return hn::Min(hn::Max(v, hn::Set(f, low)), hn::Set(f, high));
    };
    const VF4 x = cut(hn::Mul(x_weighted.value, inverse));
    const VF4 y = cut(hn::Mul(y_weighted.value, inverse));
    const VF4 left = hn::Sub(x, margin), right = hn::Sub(hn::Neg(x), margin);
    const VF4 top = hn::Sub(y, margin), bottom = hn::Sub(hn::Neg(y), margin);
    // The least of left, right, top and bottom, in four lanes.
    const VF4 xs =
        hn::Min(hn::InterleaveLower(f, left, right), hn::InterleaveUpper(f, left, right));
    const VF4 ys =
        hn::Min(hn::InterleaveLower(f, top, bottom), hn::InterleaveUpper(f, top, bottom));
    const VF4 least = hn::Min(hn::ConcatLowerLower(f, ys, xs), hn::ConcatUpperUpper(f, ys, xs));
    const I4 i;
    const VI4 ends = hn::ConvertTo(i, hn::Ceil(least));
    hn::Store(hn::Max(ends, hn::Load(i, Box().ends)), i, box.ends);
    return true;
}

/// Where the lines of two edges meet, as a weighted point.
struct Meeting {
    double weight, x, y;
};
HWY_INLINE Meeting meet(const std::int32_t* p, const std::int32_t* q) {
    const double pa = p[0], pb = p[1], pc = p[2], qa = q[0], qb = q[1], qc = q[2];
    return {pa * qb - qa * pb, pb * qc - qb * pc, pc * qa - qc * pa};
}

/// Edges with larger A or B than this give no bounding box: the products would be inexact.
inline constexpr std::int64_t max_box_slope = std::int64_t{1} << 21;

HWY_NOINLINE void box_in_doubles(const std::int32_t (*edges)[3], Box& box) {
    const Meeting m[3] = {meet(edges[0], edges[1]), meet(edges[1], edges[2]),
                          meet(edges[2], edges[0])};
    const bool positive = m[0].weight > 0 && m[1].weight > 0 && m[2].weight > 0;
    const bool negative = m[0].weight < 0 && m[1].weight < 0 && m[2].weight < 0;
    if (!positive && !negative) {
        return;
    }
    constexpr double margin = 1e-6, low = -2, high = last_px + 2;
    double least[4] = {high, high, high, high};
    for (const Meeting& corner : m) {
        const double x = HWY_MAX(low, HWY_MIN(high, corner.x / corner.weight));
        const double y = HWY_MAX(low, HWY_MIN(high, corner.y / corner.weight));
        const double ends[4] = {x, -x, y, -y};
        for (int k = 0; k < 4; ++k) {
            least[k] = HWY_MIN(least[k], ends[k]);
        }
    }
    for (int k = 0; k < 4; ++k) {
        box.ends[k] = HWY_MAX(box.ends[k], static_cast<int>(std::ceil(least[k] - margin)));
    }
}

/// Fills in the bounding box, for large coefficients. False as find_box() does.
HWY_NOINLINE bool find_large_box(const Triangle& t, Box& box) {
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
    if (slope < max_box_slope) {
        box_in_doubles(edges, box);
    }
    return true;
}

/// 2^(n-1) for the widths n of sign tests that a triangle may have (but 2^31 - 1 for 32), else 0.
HWY_INLINE VI4 sign_limit(VI4 op) {
    const I4 i;
    const VI4 n = hn::And(op, hn::Set(i, 0xFF));
    const auto limit = [&](std::size_t k, std::int32_t value) PXPL5_BODY {
        const VI4 width = hn::Set(i, static_cast<std::int32_t>(shape::edge_widths[k]));
        return hn::And(hn::VecFromMask(i, hn::Eq(n, width)), hn::Set(i, value));
    };
    static_assert(shape::edge_widths == std::array{16U, 24U, 32U});
    return hn::Or(hn::Or(limit(0, 1 << 15), limit(1, 1 << 23)), limit(2, INT32_MAX));
}

/// Fills in the bounding box. False if one of the edges has another width than those of the shape,
/// or could leave its n bits somewhere in the region: then bit n-1 is not the sign, and the
/// instructions run one by one.
HWY_INLINE bool find_box(const Triangle& t, Box& box) {
    const auto* signed_words = reinterpret_cast<const std::int32_t*>(t.words);
    const I4 i;
    const VI4 e0 = hn::LoadU(i, signed_words + shape::at_edge[0]);
    const VI4 e1 = hn::LoadU(i, signed_words + shape::at_edge[1]);
    const VI4 e2 = hn::LoadU(i, signed_words + shape::at_edge[2]);
    const Lines p = lines_at(e0, e1, e2, e0), q = lines_at(e1, e2, e0, e1);
    // By bits, because the magnitude of the least number is still negative.
    const VI4 upper =
        hn::And(hn::Or(hn::Or(hn::Abs(p.a), hn::Abs(p.b)), hn::Abs(p.c)), hn::Set(i, -max_small));
    const auto small = hn::Eq(upper, hn::Zero(i));
    // An edge's values lie between those at the region's corners.
    const VI4 along_x = hn::Mul(p.a, hn::Set(i, last_px)),
              along_y = hn::Mul(p.b, hn::Set(i, last_px));
    const VI4 zero = hn::Zero(i);
    const VI4 high = hn::Add(p.c, hn::Add(hn::Max(along_x, zero), hn::Max(along_y, zero)));
    const VI4 low = hn::Add(p.c, hn::Add(hn::Min(along_x, zero), hn::Min(along_y, zero)));
    const VI4 most = hn::Max(high, hn::Not(low));
    const bool in_floats =
        hn::AllTrue(i, hn::And(small, hn::Lt(most, sign_limit(p.op)))) && box_in_floats(p, q, box);
    return in_floats || find_large_box(t, box);
}

// ---- drawing

/// A x + B y + C, modulo 2^32.
HWY_INLINE V plane_on(const std::uint32_t* plane, V x, V y) {
    return hn::Add(hn::Add(hn::Mul(x, splat(plane[0])), hn::Mul(y, splat(plane[1]))),
                   splat(plane[2]));
}

/// The enabled bits that the newest triangle left, by vector; all others are 0.
struct EnableLog {
    struct Entry {
        std::uint32_t index, bits;
    };
    std::size_t count = 0;
    Entry entries[isa::region_pixels / lanes];
};

/// Draws the vector whose first pixel is (x, y), where `bits` lie inside all edges.
HWY_INLINE void draw_vector(PixelArray& pixels, const Triangle& t, int x, int y, std::uint32_t bits,
                            EnableLog& log) {
    const auto ux = static_cast<std::size_t>(x), uy = static_cast<std::size_t>(y);
    const std::size_t index = hal::pixel_index({ux, uy});
    auto& columns = pixels.blocks[index / hal::block_pixels].columns;
    std::uint32_t* depth = &columns[0][index % hal::block_pixels];
    const V px = hn::Add(lane_x(), splat(ux)), py = hn::Add(lane_y(), splat(uy));

    const V q = plane_on(t.z(), px, py);
    const V stored = hn::Load(D(), depth);
#ifdef PXPL5_PLANTED_BUG  // Wrong on purpose, for tests/host/inspect: a lone pixel is not tested.
    if ((bits & (bits - 1)) != 0)
#endif
        bits &= bits_of(hn::Lt(hn::ShiftRight<8>(q), hn::ShiftRight<8>(stored)));
    if (bits == 0) {
        return;
    }
    const M mask = mask_of(bits);
    const V front = hn::Or(hn::AndNot(splat(surface_bits), q), splat(t.surface()));
    hn::Store(hn::IfThenElse(mask, front, stored), D(), depth);

    std::uint32_t* normal = &columns[1][index % hal::block_pixels];
    const V old = hn::Load(D(), normal);
    const V field = splat(normal_mask);
    const V nx = hn::And(hn::ShiftRight<16>(plane_on(t.normal(0), px, py)), field);
    const V ny = hn::And(hn::ShiftRight<16>(plane_on(t.normal(1), px, py)), field);
    const V nz = hn::And(hn::ShiftRight<16>(plane_on(t.normal(2), px, py)), field);
    const V word = hn::Or(hn::Or(nx, hn::ShiftLeft<10>(ny)),
                          hn::Or(hn::ShiftLeft<20>(nz), hn::And(old, splat(beside_normal))));
    hn::Store(hn::IfThenElse(mask, word, old), D(), normal);
    log.entries[log.count++] = {static_cast<std::uint32_t>(index), bits};
}

HWY_INLINE void draw(PixelArray& pixels, const Triangle& t, const Box& box, EnableLog& log) {
    log.count = 0;
    constexpr int step_x = static_cast<int>(hal::tile_side), step_y = static_cast<int>(lane_rows);
    const int x0 = box.x0() & ~(step_x - 1), y0 = box.y0() & ~(step_y - 1);
    const V px = hn::Add(lane_x(), splat(static_cast<std::uint32_t>(x0)));
    const V py = hn::Add(lane_y(), splat(static_cast<std::uint32_t>(y0)));
    V row[3], across[3], down[3];
    for (std::size_t k = 0; k < 3; ++k) {
        row[k] = plane_on(t.edge(k), px, py);
        across[k] = splat(t.edge(k)[0] * step_x);
        down[k] = splat(t.edge(k)[1] * step_y);
    }
    for (int y = y0; y <= box.y1(); y += step_y) {
        V e0 = row[0], e1 = row[1], e2 = row[2];
        for (int x = x0; x <= box.x1(); x += step_x) {
            const auto outside = hn::BitCast(DI(), hn::Or(hn::Or(e0, e1), e2));
            const M out = hn::RebindMask(D(), hn::Lt(outside, hn::Zero(DI())));
            const std::uint32_t bits = ~bits_of(out) & all_lanes;
            if (bits != 0) {
                draw_vector(pixels, t, x, y, bits, log);
            }
            e0 = hn::Add(e0, across[0]);
            e1 = hn::Add(e1, across[1]);
            e2 = hn::Add(e2, across[2]);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            row[k] = hn::Add(row[k], down[k]);
        }
    }
}

/// Sets the enables of all pixels to what the log says.
HWY_INLINE void write_enables(PixelArray& pixels, const EnableLog& log) {
    pixels.enable.fill(0);
    pixels.occupied = {};
    for (std::size_t i = 0; i < log.count; ++i) {
        store_bits(pixels.enable, log.entries[i].index, log.entries[i].bits);
        pixels.set_occupied(log.entries[i].index / hal::block_pixels, true);
    }
}

/// Cycles of a triangle, but for the widths of its edges' sign tests.
constexpr std::uint64_t fixed_cycles() {
    const auto cycles = [](std::uint32_t word) {
        const isa::Instruction in = *isa::decode(word);
        return std::uint64_t{isa::info(in.op).cycles(in.operands)};
    };
    std::uint64_t sum = cycles(shape::enable_word) + cycles(shape::z_test_word) +
                        cycles(shape::z_store_word) + cycles(shape::surface_word(0));
    for (std::size_t k = 0; k < 3; ++k) {
        sum += cycles(shape::normal_words[k]) + cycles(shape::edge_word(shape::edge_widths[0])) -
               shape::edge_widths[0];
    }
    return sum;
}
constexpr bool edge_costs_one_cycle_a_bit() {
    const isa::OpInfo& row = isa::info(isa::Op::tree_ge_zero);
    return row.cycles({0, 0, 32}) - row.cycles({0, 0, 16}) == 16;
}
static_assert(edge_costs_one_cycle_a_bit());

isa::Taken run_triangles(Board& board, const std::uint32_t* words, std::size_t word_count) {
    constexpr std::uint64_t cycles = fixed_cycles();
    isa::Taken taken;
    EnableLog log;
    while (taken.words + shape::word_count <= word_count) {
        const Triangle triangle{words + taken.words};
        Box box;
        if (!has_shape(triangle.words) || !find_box(triangle, box)) {
            break;
        }
        draw(board.pixels, triangle, box, log);
        taken.words += shape::word_count;
        taken.instructions += shape::instruction_count;
        taken.cycles +=
            cycles + triangle.edge_width(0) + triangle.edge_width(1) + triangle.edge_width(2);
    }
    if (taken.words != 0) {
        write_enables(board.pixels, log);
    }
    return taken;
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
