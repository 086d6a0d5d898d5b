// Triangles, fast: the ten instructions of isa/triangle_shape.hpp as one pass over the vectors of
// the triangle's bounding box.
//
// Nobody can see the enables of a triangle that another one follows, whose SETENABS overwrites
// them. So they are noted while a triangle is drawn, and written for the last one of a run only.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/triangle.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles what follows once per target.
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
/// Edges with larger A or B than this give no bounding box: the products below would be inexact.
inline constexpr std::int64_t max_box_slope = std::int64_t{1} << 21;
inline constexpr int last_px = layout::size_px - 1;

struct Plane {
    std::int32_t a, b, c;
    HWY_INLINE std::uint32_t at(int x, int y) const {
        return static_cast<std::uint32_t>(a) * static_cast<std::uint32_t>(x) +
               static_cast<std::uint32_t>(b) * static_cast<std::uint32_t>(y) +
               static_cast<std::uint32_t>(c);
    }
    HWY_INLINE V on(V x, V y) const {
        return hn::Add(hn::Add(hn::Mul(x, splat(static_cast<std::uint32_t>(a))),
                               hn::Mul(y, splat(static_cast<std::uint32_t>(b)))),
                       splat(static_cast<std::uint32_t>(c)));
    }
};
HWY_INLINE Plane plane_at(const std::uint32_t* words) {
    Plane plane;
    std::memcpy(&plane, words + 1, sizeof plane);
    return plane;
}

struct Triangle {
    Plane edges[3], z, normals[3];
    std::uint32_t surface;
    std::uint32_t edge_bits;  ///< Sum of the widths of the three sign tests.
    bool box_is_exact;
};

HWY_INLINE std::int64_t magnitude(std::int64_t v) {
    return v < 0 ? -v : v;
}

/// Takes the triangle at `words` apart. False if one of its edges could leave its n bits somewhere
/// in the region: then bit n-1 is not the sign, and the instructions run one by one.
HWY_INLINE bool decode(const std::uint32_t* words, Triangle& t) {
    t.edge_bits = 0;
    bool fits = true;
    std::int64_t slope = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        t.edges[k] = plane_at(words + shape::at_edge[k]);
        t.normals[k] = plane_at(words + shape::at_normal[k]);
        const std::uint32_t n = words[shape::at_edge[k]] & 0xFF;
        const std::int64_t a = magnitude(t.edges[k].a), b = magnitude(t.edges[k].b);
        fits &= (a + b) * last_px + magnitude(t.edges[k].c) < std::int64_t{1} << (n - 1);
        slope |= a | b;
        t.edge_bits += n;
    }
    t.z = plane_at(words + shape::at_z_test);
    t.surface = words[shape::at_surface] >> 8 & surface_bits;
    t.box_is_exact = slope < max_box_slope;
    return fits;
}

/// Pixels that may lie inside; empty if x0 > x1 or y0 > y1.
struct Box {
    int x0 = 0, y0 = 0, x1 = last_px, y1 = last_px;
};

/// Where the lines of two edges meet, as a weighted point: place = (x, y) / weight.
struct Meeting {
    double weight, x, y;
};
HWY_INLINE Meeting meet(const Plane& p, const Plane& q) {
    const double pa = p.a, pb = p.b, pc = p.c, qa = q.a, qb = q.b, qc = q.c;
    return {pa * qb - qa * pb, pb * qc - qb * pc, pc * qa - qc * pa};
}

/// Three half planes bound a triangle exactly if their weights have one sign; its corners are then
/// the meetings. All products are below 2^53 and so exact; the quotients are off by less than the
/// margin wherever they matter, in 0..127.
HWY_INLINE Box bounding_box(const Triangle& t) {
    const Meeting m[3] = {meet(t.edges[0], t.edges[1]), meet(t.edges[1], t.edges[2]),
                          meet(t.edges[2], t.edges[0])};
    const bool positive = m[0].weight > 0 && m[1].weight > 0 && m[2].weight > 0;
    const bool negative = m[0].weight < 0 && m[1].weight < 0 && m[2].weight < 0;
    if (!t.box_is_exact || !(positive || negative)) {
        return {};
    }
    constexpr double margin = 1e-6, outside = last_px + 2;
    double x[3], y[3];
    for (int k = 0; k < 3; ++k) {
        x[k] = HWY_MAX(-2.0, HWY_MIN(outside, m[k].x / m[k].weight));
        y[k] = HWY_MAX(-2.0, HWY_MIN(outside, m[k].y / m[k].weight));
    }
    const double left = HWY_MIN(x[0], HWY_MIN(x[1], x[2])) - margin;
    const double right = HWY_MAX(x[0], HWY_MAX(x[1], x[2])) + margin;
    const double top = HWY_MIN(y[0], HWY_MIN(y[1], y[2])) - margin;
    const double bottom = HWY_MAX(y[0], HWY_MAX(y[1], y[2])) + margin;
    // Adding 3 makes the numbers positive, so that the cast rounds down; +4-3 rounds up or on.
    return {HWY_MAX(0, static_cast<int>(left + 4) - 4 + (left + 4 > static_cast<int>(left + 4))),
            HWY_MAX(0, static_cast<int>(top + 4) - 4 + (top + 4 > static_cast<int>(top + 4))),
            HWY_MIN(last_px, static_cast<int>(right + 4) - 4),
            HWY_MIN(last_px, static_cast<int>(bottom + 4) - 4)};
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

    const V q = t.z.on(px, py);
    const V stored = hn::Load(D(), depth);
    const auto nearer = hn::Lt(hn::BitCast(DI(), hn::ShiftRight<8>(q)),
                            hn::BitCast(DI(), hn::ShiftRight<8>(stored)));
    bits &= bits_of(hn::RebindMask(D(), nearer));
    if (bits == 0) {
        return;
    }
    const M mask = mask_of(bits);
    const V front = hn::Or(hn::AndNot(splat(surface_bits), q), splat(t.surface));
    hn::Store(hn::IfThenElse(mask, front, stored), D(), depth);

    std::uint32_t* normal = &columns[1][index % hal::block_pixels];
    const V old = hn::Load(D(), normal);
    const V field = splat(normal_mask);
    const V nx = hn::And(hn::ShiftRight<16>(t.normals[0].on(px, py)), field);
    const V ny = hn::And(hn::ShiftRight<16>(t.normals[1].on(px, py)), field);
    const V nz = hn::And(hn::ShiftRight<16>(t.normals[2].on(px, py)), field);
    const V word = hn::Or(hn::Or(nx, hn::ShiftLeft<10>(ny)),
                          hn::Or(hn::ShiftLeft<20>(nz), hn::And(old, splat(beside_normal))));
    hn::Store(hn::IfThenElse(mask, word, old), D(), normal);
    log.entries[log.count++] = {static_cast<std::uint32_t>(index), bits};
}

HWY_INLINE void draw(PixelArray& pixels, const Triangle& t, EnableLog& log) {
    log.count = 0;
    const Box box = bounding_box(t);
    constexpr int step_x = static_cast<int>(hal::tile_side), step_y = static_cast<int>(lane_rows);
    const int x0 = box.x0 & ~(step_x - 1), y0 = box.y0 & ~(step_y - 1);
    V offset[3], across[3];
    for (int k = 0; k < 3; ++k) {
        const Plane& e = t.edges[k];
        offset[k] = Plane{e.a, e.b, 0}.on(lane_x(), lane_y());
        across[k] = splat(static_cast<std::uint32_t>(e.a) * step_x);
    }
    for (int y = y0; y <= box.y1; y += step_y) {
        V e0 = hn::Add(offset[0], splat(t.edges[0].at(x0, y)));
        V e1 = hn::Add(offset[1], splat(t.edges[1].at(x0, y)));
        V e2 = hn::Add(offset[2], splat(t.edges[2].at(x0, y)));
        for (int x = x0; x <= box.x1; x += step_x) {
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
    isa::Taken taken;
    Triangle triangle;
    EnableLog log;
    while (taken.words + shape::word_count <= word_count && shape::matches(words + taken.words) &&
           decode(words + taken.words, triangle)) {
        draw(board.pixels, triangle, log);
        taken.words += shape::word_count;
        taken.instructions += shape::instruction_count;
        taken.cycles += fixed_cycles() + triangle.edge_bits;
    }
    if (taken.words != 0) {
        write_enables(board.pixels, log);
    }
    return taken;
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
