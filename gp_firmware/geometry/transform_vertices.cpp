// The inner loop of transform(). It handles one vertex per vector lane.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "gp_firmware/geometry/transform_vertices.cpp"
#include <hwy/foreach_target.h>
// highway.h must follow foreach_target.h, which compiles this file once per target.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstring>

#include "gp_firmware/geometry/lanes-inl.hpp"
#include "gp_firmware/geometry/transform.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::gp::HWY_NAMESPACE {

namespace region = isa::region;

inline constexpr int guard = guard_px * subpixels;

/// Clamps v. Maps NaN to `low`.
HWY_INLINE F clamp(F v, F low, F high) {
    v = hn::IfThenElse(hn::Gt(v, low), v, low);
    return hn::IfThenElse(hn::Lt(v, high), v, high);
}

/// The words of some vertices: position, nx and ny, nz.
struct VertexWords {
    I x, y, z, normal_xy, normal_z;
};

/// Loads vertices. Copying all words but the last is faster than gathering four words.
HWY_INLINE VertexWords words_of(const Vertex* vertices) {
    constexpr std::size_t copied_bytes = 16;
    static_assert(offsetof(Vertex, p_voxel) == 0 && offsetof(Vertex, normal) == 12 &&
                  sizeof(Vertex) == copied_bytes + sizeof(std::int32_t));
    alignas(64) std::array<std::int32_t, 4 * lanes> first_words;
    alignas(64) std::array<std::int32_t, lanes> last_word;
    for (std::size_t i = 0; i < lanes; ++i) {
        std::memcpy(&first_words[4 * i], vertices + i, copied_bytes);
        std::memcpy(&last_word[i], reinterpret_cast<const char*>(vertices + i) + copied_bytes,
                    sizeof last_word[i]);
    }
    VertexWords words;
    hn::LoadInterleaved4(DI(), first_words.data(), words.x, words.y, words.z, words.normal_xy);
    words.normal_z = hn::Load(DI(), last_word.data());
    return words;
}

struct Positions {
    F x, y, z;
};

/// One coordinate on the grid, and its Outside bit if it exceeds its limits.
struct Coordinate {
    I value, outside;
};

struct Limits {
    int low, high;
    std::uint32_t below, above;  ///< Outside bits.
};

/// Returns one homogeneous coordinate: a row of the matrix times the position.
HWY_INLINE F row_of(const Projection& m, std::size_t row, const Positions& p) {
    return hn::Add(hn::Add(hn::Add(hn::Mul(splat(m.voxel_to_grid[0][row]), p.x),
                                   hn::Mul(splat(m.voxel_to_grid[1][row]), p.y)),
                           hn::Mul(splat(m.voxel_to_grid[2][row]), p.z)),
                   splat(m.voxel_to_grid[3][row]));
}

/// Clamps and rounds a coordinate. `bias` makes it positive, because conversion truncates.
HWY_INLINE Coordinate coordinate(F p, const Limits& limits, float bias) {
    const F low = splat(static_cast<float>(limits.low));
    const F high = splat(static_cast<float>(limits.high));
    const auto inside = [](auto is_inside, std::uint32_t bit) HWY_ATTR {
        return hn::IfThenZeroElse(hn::RebindMask(DI(), is_inside), splat(static_cast<int>(bit)));
    };
    return {hn::ConvertTo(DI(), hn::Add(clamp(p, low, high), splat(bias))),
            hn::Or(inside(hn::Ge(p, low), limits.below), inside(hn::Le(p, high), limits.above))};
}

/// Rotates normals and packs them like GridVertex::normal. The arguments are a vertex's last words.
HWY_INLINE I turned(const Projection& m, I words_xy, I words_z) {
    constexpr int unit = region::normal_unit, above = 2 * unit, bits = 10;
    const F nx = hn::ConvertTo(DF(), hn::ShiftRight<16>(hn::ShiftLeft<16>(words_xy)));
    const F ny = hn::ConvertTo(DF(), hn::ShiftRight<16>(words_xy));
    const F nz = hn::ConvertTo(DF(), hn::ShiftRight<16>(hn::ShiftLeft<16>(words_z)));
    const auto component = [&](std::size_t k) HWY_ATTR {
        const F n = hn::Add(hn::Add(hn::Mul(splat(m.normal_to_eye[0][k]), nx),
                                    hn::Mul(splat(m.normal_to_eye[1][k]), ny)),
                            hn::Mul(splat(m.normal_to_eye[2][k]), nz));
        const F held = clamp(n, splat(float{-unit}), splat(float{unit}));
        const I rounded =
            hn::Sub(hn::ConvertTo(DI(), hn::Add(held, splat(above + 0.5F))), splat(above));
        return hn::And(rounded, splat((1 << bits) - 1));
    };
    return hn::Or(component(0),
                  hn::Or(hn::ShiftLeft<bits>(component(1)), hn::ShiftLeft<2 * bits>(component(2))));
}

/// Returns the Outside bits of the user's planes.
HWY_INLINE I cut_off(const Projection& m, const Positions& p) {
    I outside = hn::Zero(DI());
    std::uint32_t bit = outside_user;
    for (const glm::vec4& plane : m.clip_planes) {
        const F distance =
            hn::Add(hn::Add(hn::Add(hn::Mul(splat(plane.x), p.x), hn::Mul(splat(plane.y), p.y)),
                            hn::Mul(splat(plane.z), p.z)),
                    splat(plane.w));
        const auto kept = hn::RebindMask(DI(), hn::Ge(distance, hn::Zero(DF())));
        outside = hn::Or(outside, hn::IfThenZeroElse(kept, splat(static_cast<int>(bit))));
        bit <<= 1;
    }
    return outside;
}

/// Transforms `lanes` vertices. Stores and returns their Outside bits.
HWY_INLINE I transform_some(const Vertex* vertices, const Projection& m, GridVertex* out,
                            std::uint32_t* outside) {
    constexpr Limits across{-guard, guard, outside_left, outside_right};
    constexpr Limits down{-guard, guard, outside_top, outside_bottom};
    constexpr Limits deep{region::z_margin, region::z_far - region::z_margin, outside_near,
                          outside_far};
    const VertexWords words = words_of(vertices);
    const Positions p{hn::BitCast(DF(), words.x), hn::BitCast(DF(), words.y),
                      hn::BitCast(DF(), words.z)};
    const F w = row_of(m, 3, p);
    const Coordinate x = coordinate(hn::Div(row_of(m, 0, p), w), across, guard + 0.5F);
    const Coordinate y = coordinate(hn::Div(row_of(m, 1, p), w), down, guard + 0.5F);
    const Coordinate z = coordinate(hn::Div(row_of(m, 2, p), w), deep, 0);
    const auto before_eye = hn::RebindMask(DI(), hn::Ge(w, splat(w_min)));
    const I by_view = hn::IfThenElse(before_eye, hn::Or(x.outside, hn::Or(y.outside, z.outside)),
                                     splat(int{outside_w}));
    const I all = hn::Or(by_view, cut_off(m, p));
    hn::StoreInterleaved4(hn::Sub(x.value, splat(guard)), hn::Sub(y.value, splat(guard)), z.value,
                          turned(m, words.normal_xy, words.normal_z), DI(),
                          reinterpret_cast<std::int32_t*>(out));
    hn::StoreU(all, DI(), reinterpret_cast<std::int32_t*>(outside));
    return all;
}

std::uint32_t transform_all(std::span<const Vertex> vertices, const Projection& projection,
                            GridVertex* out, std::uint32_t* outside) {
    I any = hn::Zero(DI());
    std::size_t i = 0;
    for (; i + lanes <= vertices.size(); i += lanes) {
        any = hn::Or(any, transform_some(&vertices[i], projection, out + i, outside + i));
    }
    alignas(64) std::array<std::uint32_t, lanes> some_bits;
    hn::Store(any, DI(), reinterpret_cast<std::int32_t*>(some_bits.data()));
    std::uint32_t bits = 0;
    for (const std::uint32_t some : some_bits) {
        bits |= some;
    }
    if (const std::size_t rest = vertices.size() - i; rest > 0) {
        std::array<Vertex, lanes> last{};
        std::array<GridVertex, lanes> last_out;
        std::copy_n(vertices.begin() + static_cast<std::ptrdiff_t>(i), rest, last.begin());
        transform_some(last.data(), projection, last_out.data(), some_bits.data());
        std::copy_n(last_out.begin(), rest, out + i);
        for (std::size_t k = 0; k < rest; ++k) {
            bits |= outside[i + k] = some_bits[k];
        }
    }
    return bits;
}

}  // namespace pxpl5::gp::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::gp {

std::uint32_t transform(std::span<const Vertex> vertices, const Projection& projection,
                        std::span<GridVertex> out, std::span<std::uint32_t> outside,
                        VectorTarget target) {
    assert(out.size() == vertices.size());
    assert(outside.size() == vertices.size());
    return PXPL5_PER_TARGET(transform_all)[target](vertices, projection, out.data(),
                                                   outside.data());
}

}  // namespace pxpl5::gp
#endif
