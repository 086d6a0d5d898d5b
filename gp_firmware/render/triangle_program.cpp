#include "gp_firmware/render/triangle_program.hpp"

#include <algorithm>

#include "isa/triangle_shape.hpp"

namespace pxpl5::gp {

namespace {

namespace shape = isa::triangle;

bool fits(std::int64_t low, std::int64_t high, std::uint32_t width) {
    const std::int64_t end = std::int64_t{1} << (width - 1);
    return low >= -end && high < end;
}

}  // namespace

std::optional<RegionEdge> region_edge(const Edge& edge, int x0, int y0) {
    constexpr std::int64_t last = isa::region::size_px - 1;
    const std::int64_t c = edge.c + edge.a * x0 + edge.b * y0;
    const std::int64_t along_x = edge.a * last, along_y = edge.b * last;
    const std::int64_t high =
        c + std::max(along_x, std::int64_t{0}) + std::max(along_y, std::int64_t{0});
    const std::int64_t low =
        c + std::min(along_x, std::int64_t{0}) + std::min(along_y, std::int64_t{0});
    if (high < 0) {
        return std::nullopt;
    }
    for (const std::uint32_t width : shape::edge_widths) {
        if (fits(low, high, width)) {
            return RegionEdge{width, static_cast<std::uint32_t>(edge.a),
                              static_cast<std::uint32_t>(edge.b), static_cast<std::uint32_t>(c)};
        }
    }
    // An edge that crosses the region has values below 2^28, so this one does not.
    return RegionEdge{shape::edge_widths[0], 0, 0, 0};
}

void write_triangle(const std::array<RegionEdge, 3>& edges, const AttributePlanes& planes, int x0,
                    int y0, std::uint32_t surface_word, std::uint32_t* words) {
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
        put(shape::at_edge[k], shape::edge_word(edges[k].width), edges[k].a, edges[k].b,
            edges[k].c);
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
