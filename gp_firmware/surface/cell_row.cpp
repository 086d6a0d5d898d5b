#include "gp_firmware/surface/cell_row.hpp"

#include <bit>
#include <cstring>

// Highway compiles the part below once per kind of vector machine.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gp_firmware/surface/cell_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "isa/contract/vector_target.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Bits of 64 cells: of the four voxels at their lower x, and of those at their upper x.
struct CellWord {
    std::array<std::uint64_t, 4> low, high;

    CellWord(const CellMasks& masks, std::size_t w) {
        for (std::size_t i = 0; i < 4; ++i) {
            low[i] = masks[i][w];
            high[i] = low[i] >> 1 | masks[i][w + 1] << 63;
        }
    }
    std::uint64_t crossed() const {
        const std::uint64_t any =
            low[0] | low[1] | low[2] | low[3] | high[0] | high[1] | high[2] | high[3];
        const std::uint64_t all =
            low[0] & low[1] & low[2] & low[3] & high[0] & high[1] & high[2] & high[3];
        return any & ~all;
    }
};

/// The inside corners of 64 cells, one byte each.
HWY_INLINE void inside_corners(const CellWord& word, std::uint8_t* out) {
    const hn::CappedTag<std::uint8_t, 64> d;
    const std::size_t lanes = hn::Lanes(d);
    for (std::size_t x = 0; x < 64; x += lanes) {
        auto inside = hn::Zero(d);
        const auto add = [&](std::uint64_t mask, unsigned corner) {
            const std::uint64_t part = mask >> x;
            const auto bits = hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&part));
            inside = hn::Or(inside, hn::IfThenElseZero(
                                        bits, hn::Set(d, static_cast<std::uint8_t>(1U << corner))));
        };
        for (unsigned i = 0; i < 4; ++i) {
            add(word.low[i], 2 * i);
            add(word.high[i], 2 * i + 1);
        }
        hn::Store(inside, d, out + x);
    }
}

std::size_t find_in_vectors(const CellMasks& masks, std::size_t cell_count, CrossedCell* out) {
    HWY_ALIGN std::array<std::uint8_t, 64> inside;
    std::size_t count = 0;
    for (std::size_t x = 0; x < cell_count; x += 64) {
        const CellWord word(masks, x / 64);
        std::uint64_t crossed = word.crossed();
        if (cell_count - x < 64) {
            crossed &= (std::uint64_t{1} << (cell_count - x)) - 1;
        }
        if (crossed == 0) {
            continue;
        }
        inside_corners(word, inside.data());
        for (; crossed != 0; crossed &= crossed - 1) {
            const auto bit = static_cast<std::size_t>(std::countr_zero(crossed));
            out[count++] = static_cast<CrossedCell>((x + bit) << 8 | inside[bit]);
        }
    }
    return count;
}

using Vertices = hn::CappedTag<std::uint32_t, max_listed_corners>;

/// vertices  The cell's first slot.
HWY_INLINE void list_corners(const std::uint32_t* vertices, const CaseSlots::Corners& slots,
                             std::size_t count, std::uint32_t* out) {
    constexpr Vertices d;
    if constexpr (hn::MaxLanes(d) == max_listed_corners) {
        // One permutation writes all corners. The next cell overwrites those beyond `count`.
        const auto order =
            hn::PromoteTo(d, hn::LoadU(hn::Rebind<std::uint8_t, Vertices>(), slots.data()));
        hn::StoreU(hn::TableLookupLanes(hn::LoadU(d, vertices), hn::IndicesFromVec(d, order)), d,
                   out);
    } else {
        for (std::size_t i = 0; i < count; ++i) {
            out[i] = vertices[slots[i]];
        }
    }
}

/// Writes the origins of a cell's triangles. The first one is `origin`.
HWY_INLINE void note_origins(Origin origin, std::size_t count, Origin* out) {
    constexpr hn::CappedTag<std::uint64_t, max_listed_triangles> d;
    if constexpr (hn::MaxLanes(d) == max_listed_triangles) {
        constexpr Origin next{0, 0, 0, 0, 1, 0};
        const auto numbers =
            hn::Mul(hn::Iota(d, 0), hn::Set(d, std::bit_cast<std::uint64_t>(next)));
        hn::StoreU(hn::Set(d, std::bit_cast<std::uint64_t>(origin)) + numbers, d,
                   reinterpret_cast<std::uint64_t*>(out));
    } else {
        for (; origin.triangle < count; ++origin.triangle) {
            out[origin.triangle] = origin;
        }
    }
}

CellsDone triangles_in_vectors(std::span<const CrossedCell> cells, const std::uint32_t* vertices,
                               const CaseSlots& slots, int y, TriangleRoom room) {
    const auto& corners = slots.corners[static_cast<std::size_t>(y & 1)];
    std::size_t done = 0, ambiguous = 0, written = 0;
    for (; done < cells.size(); ++done) {
        const std::size_t x = cells[done] >> 8, inside = cells[done] & 255;
        const std::size_t count = slots.corner_count[inside];
        if (count == unlisted) {
            break;
        }
        list_corners(vertices + slots_per_voxel * x, corners[inside], count,
                     room.indices + written);
        if (room.origins != nullptr) {
            note_origins({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                          static_cast<std::uint8_t>(inside), 0, 0, 0},
                         count / 3, room.origins + written / 3);
        }
        written += count;
        ambiguous += slots.has_ambiguous_face[inside];
    }
    return {done, ambiguous, written};
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::gp {

std::size_t find_crossed_cells(VectorTarget target, const CellMasks& masks, std::size_t cell_count,
                               CrossedCell* out) {
    return PXPL5_PER_TARGET(find_in_vectors)[target](masks, cell_count, out);
}

CellsDone make_triangles(VectorTarget target, std::span<const CrossedCell> cells,
                         const std::uint32_t* vertices, const CaseSlots& slots, int y,
                         TriangleRoom room) {
    return PXPL5_PER_TARGET(triangles_in_vectors)[target](cells, vertices, slots, y, room);
}

}  // namespace pxpl5::gp
#endif
