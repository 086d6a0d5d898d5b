// Triangle program: the instruction words of one triangle in one region.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "gp_firmware/render/plane_setup.hpp"
#include "isa/contract/triangle_shape.hpp"

namespace pxpl5::gp {

/// An edge in the form of a region's TREEgeZERO.
struct RegionEdge {
    std::uint32_t word = 0;  ///< The instruction; no value over the region overflows its width.
    std::uint32_t a = 0, b = 0, c = 0;
};

/// Moves `edge` to the region whose first pixel is (x0, y0).
///
/// Returns  Nothing if no pixel of the region is inside. If all pixels are inside, but values have
///          more than 32 bits, the edge becomes 0 >= 0.
inline std::optional<RegionEdge> region_edge(const Edge& edge, int x0, int y0) {
    constexpr std::int64_t last = region_px - 1;
    constexpr std::uint32_t narrow = isa::triangle::edge_word(16),
                            middle = isa::triangle::edge_word(24),
                            wide = isa::triangle::edge_word(32);
    const std::int64_t c = edge.c + edge.a * x0 + edge.b * y0;
    const std::int64_t along_x = edge.a * last, along_y = edge.b * last;
    const std::int64_t high =
        c + std::max(along_x, std::int64_t{0}) + std::max(along_y, std::int64_t{0});
    const std::int64_t low =
        c + std::min(along_x, std::int64_t{0}) + std::min(along_y, std::int64_t{0});
    if (high < 0) {
        return std::nullopt;
    }
    const auto a = static_cast<std::uint32_t>(edge.a), b = static_cast<std::uint32_t>(edge.b);
    const auto c_low = static_cast<std::uint32_t>(c);
    // The width needs the bits of the value farthest from 0, and a sign.
    const std::int64_t farthest = std::max(high, ~low);
    if (farthest < 1 << 15) {
        return RegionEdge{narrow, a, b, c_low};
    }
    if (farthest < 1 << 23) {
        return RegionEdge{middle, a, b, c_low};
    }
    if (farthest < std::int64_t{1} << 31) {
        return RegionEdge{wide, a, b, c_low};
    }
    // An edge that crosses the region has values below 2^28, so this one does not.
    return RegionEdge{narrow, 0, 0, 0};
}

/// Writes the isa::triangle::word_count words of the shape in isa/contract/triangle_shape.hpp.
///
/// surface_word  isa::triangle::surface_word() of the surface.
inline void write_triangle(const std::array<RegionEdge, 3>& edges, const AttributePlanes& planes,
                           int x0, int y0, std::uint32_t surface_word, std::uint32_t* words) {
    namespace shape = isa::triangle;
    const auto put = [words](std::size_t at, std::uint32_t word, std::uint32_t a, std::uint32_t b,
                             std::uint32_t c) {
        words[at] = word;
        words[at + 1] = a;
        words[at + 2] = b;
        words[at + 3] = c;
    };
    const auto x = static_cast<std::uint32_t>(x0), y = static_cast<std::uint32_t>(y0);
    const auto c_here = [&](std::size_t k) {
        return planes.c[k] + planes.a[k] * x + planes.b[k] * y;
    };
    words[shape::at_enable] = shape::enable_word;
    for (std::size_t k = 0; k < 3; ++k) {
        put(shape::at_edge[k], edges[k].word, edges[k].a, edges[k].b, edges[k].c);
    }
    put(shape::at_z_test, shape::z_test_word, planes.a[0], planes.b[0], c_here(0));
    put(shape::at_z_store, shape::z_store_word, planes.a[0], planes.b[0], c_here(0));
    for (std::size_t k = 0; k < 3; ++k) {
        put(shape::at_normal[k], shape::normal_words[k], planes.a[k + 1], planes.b[k + 1],
            c_here(k + 1));
    }
    words[shape::at_surface] = surface_word;
}

}  // namespace pxpl5::gp
