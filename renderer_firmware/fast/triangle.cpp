// Triangles, fast: the ten instructions of isa/contract/triangle_shape.hpp as one fused pass over
// the vectors of pixels in the triangle's bounding box.
//
// The code processes triangles in batches, each step for the whole batch: the boxes; the vectors
// that each triangle covers; depth test and stores for these vectors, in the order of the
// triangles. So the processor predicts the ends of its loops, which it could not do with a few
// pixels per triangle.
//
// The SETENABS of the next triangle overwrites the enables of a triangle before any use. So the
// code records the enables of each triangle, and stores only those of the last triangle of a run.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/triangle.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include "renderer_firmware/fast/triangle_words-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

namespace layout = isa::region;
static_assert(layout::surface.address == 0 && layout::surface.width == 8 &&
                  layout::z.address == 8 && layout::z.width == 24 && layout::z_fraction_bits == 8,
              "column 0 is z above the surface number, and Q of z is the column itself");
static_assert(layout::normal_x.address == 32 && layout::normal_y.address == 42 &&
                  layout::normal_z.address == 52 && layout::normal_z.width == 10 &&
                  layout::normal_x.width + layout::normal_fraction_bits <= 32,
              "column 1 is the normal, and its planes fit 32-bit lanes");

inline constexpr std::uint32_t normal_mask = (1U << 10) - 1;
inline constexpr std::uint32_t beside_normal = 3U << 30;  ///< Bits 62 and 63: not in any field.

/// A x + B y + C, modulo 2^32.
HWY_INLINE V plane_on(const std::uint32_t* plane, V x, V y) {
    return hn::Add(hn::Add(hn::Mul(x, splat(plane[0])), hn::Mul(y, splat(plane[1]))),
                   splat(plane[2]));
}

/// A vector of pixels, some of which are inside a triangle of the batch.
struct Covered {
    std::uint8_t x, y;  ///< Position of the first pixel.
    std::uint16_t triangle;
    std::uint32_t bits;  ///< Before drawing: inside all edges. Afterwards: also in front.
};

/// The vectors that the newest triangles cover.
struct Cover {
    /// A triangle may cover the whole region.
    static constexpr std::size_t whole = region_pixels / lanes;
    static constexpr std::size_t spare = 512;

    std::size_t count = 0, drawn = 0;
    Covered at[spare + whole + 1];

    /// Records a vector if bits are set, without an unpredictable branch.
    HWY_INLINE void add(const Covered& c) {
        at[count] = c;
        count += c.bits != 0 ? 1 : 0;
    }
};

/// Records the vectors that a triangle covers.
HWY_INLINE void find_covered(const Triangle& t, std::size_t number, const Box& box, Cover& cover) {
    constexpr int step_x = static_cast<int>(hal::tile_side), step_y = static_cast<int>(lane_rows);
    const int x0 = box.x0 & ~(step_x - 1), y0 = box.y0 & ~(step_y - 1);
    const V px = hn::Add(lane_x(), splat(static_cast<std::uint32_t>(x0)));
    const V py = hn::Add(lane_y(), splat(static_cast<std::uint32_t>(y0)));
    V row[3], across[3], down[3];
    for (std::size_t k = 0; k < 3; ++k) {
        row[k] = plane_on(t.edge(k), px, py);
        across[k] = splat(std::uint32_t{t.edge(k)[0] * step_x});
        down[k] = splat(std::uint32_t{t.edge(k)[1] * step_y});
    }
    for (int y = y0; y <= box.y1; y += step_y) {
        V e0 = row[0], e1 = row[1], e2 = row[2];
        for (int x = x0; x <= box.x1; x += step_x) {
            const auto outside = hn::BitCast(DI(), hn::Or(hn::Or(e0, e1), e2));
            const M out = hn::RebindMask(D(), hn::Lt(outside, hn::Zero(DI())));
            cover.add({static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                       static_cast<std::uint16_t>(number), ~bits_of(out) & all_lanes});
            e0 = hn::Add(e0, across[0]);
            e1 = hn::Add(e1, across[1]);
            e2 = hn::Add(e2, across[2]);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            row[k] = hn::Add(row[k], down[k]);
        }
    }
}

/// Draws the pixels of `c`: depth test, depth, normal and surface.
HWY_INLINE void draw_covered(PixelArray& pixels, const Triangle& t, Covered& c) {
    const std::size_t index = hal::pixel_index({c.x, c.y});
    auto& columns = pixels.blocks[index / hal::block_pixels].columns;
    std::uint32_t* depth = &columns[0][index % hal::block_pixels];
    const V px = hn::Add(lane_x(), splat(c.x)), py = hn::Add(lane_y(), splat(c.y));

    const V q = plane_on(t.z(), px, py);
    const V stored = hn::Load(D(), depth);
#ifdef PXPL5_PLANTED_BUG  // A planted bug for tests/host/inspect: a lone pixel skips the depth
                          // test.
    if ((c.bits & (c.bits - 1)) != 0)
#endif
        c.bits &= bits_of(hn::Lt(hn::ShiftRight<8>(q), hn::ShiftRight<8>(stored)));
    if (c.bits == 0) {
        return;
    }
    const M mask = mask_of(c.bits);
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
}

/// Draws the part of `cover` that is not yet drawn; all of it belongs to `batch`.
HWY_INLINE void draw(PixelArray& pixels, const Batch& batch, Cover& cover) {
    for (; cover.drawn < cover.count; ++cover.drawn) {
        Covered& c = cover.at[cover.drawn];
        draw_covered(pixels, batch[c.triangle], c);
    }
}

/// Draws the triangles of `batch`, up to one that must run instruction by instruction. Returns the
/// number of drawn triangles; `cover` holds the vectors of the last of them.
HWY_INLINE std::size_t draw_batch(PixelArray& pixels, const Batch& batch, Cover& cover) {
    Boxes boxes;
    find_boxes(batch, boxes);
    std::size_t done = 0;
    for (; done < batch.count; ++done) {
        Box box = boxes[done];
        if ((boxes.known >> done & 1) == 0 && !find_large_box(batch[done], box)) {
            break;
        }
        if (done == 0 || cover.count > Cover::spare) {
            draw(pixels, batch, cover);
            cover.count = cover.drawn = 0;
        }
        find_covered(batch[done], done, box, cover);
    }
    draw(pixels, batch, cover);
    return done;
}

/// Sets the enables of all pixels to the result of the triangle with this number.
HWY_INLINE void write_enables(PixelArray& pixels, const Cover& cover, std::size_t triangle) {
    pixels.enable.fill(0);
    pixels.occupied = {};
    for (std::size_t i = cover.count; i > 0 && cover.at[i - 1].triangle == triangle; --i) {
        const Covered& c = cover.at[i - 1];
        const std::size_t index = hal::pixel_index({c.x, c.y});
        store_bits(pixels.enable, index, c.bits);
        if (c.bits != 0) {
            pixels.set_occupied(index / hal::block_pixels, true);
        }
    }
}

/// Cycles of a triangle without the widths of its edges' sign tests.
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
    Cover cover;
    std::size_t newest = 0;  // Number within its batch.
    while (taken.words + shape::word_count <= word_count) {
        const std::size_t left = (word_count - taken.words) / shape::word_count;
        const std::size_t most = HWY_MIN(left, batch_size);
        const Batch batch = read_batch(words + taken.words, most);
        if (batch.count == 0) {
            break;
        }
        const std::size_t done = draw_batch(board.pixels, batch, cover);
        for (std::size_t i = 0; i < done; ++i) {
            newest = i;
            taken.cycles +=
                cycles + batch[i].edge_width(0) + batch[i].edge_width(1) + batch[i].edge_width(2);
        }
        taken.words += done * shape::word_count;
        taken.instructions += done * shape::instruction_count;
        if (done < most) {
            break;
        }
    }
    if (taken.words != 0) {
        write_enables(board.pixels, cover, newest);
    }
    return taken;
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
