#include "gp_firmware/render/draw_slab.hpp"

#include <array>
#include <cassert>
#include <utility>

#include "gp_firmware/geometry/clip.hpp"
#include "gp_firmware/render/plane_setup.hpp"
#include "gp_firmware/render/triangle_program.hpp"
#include "isa/triangle_shape.hpp"

namespace pxpl5::gp {

namespace {

constexpr int region_bits = 7;
static_assert(1 << region_bits == isa::region::size_px);

/// Boxes of at most this many pixels are searched: most triangles of a fine surface touch no
/// centre, and to find that out here is cheaper than to send them.
constexpr int searched_px = 4;

/// What stays the same for all triangles of a slab.
struct Target {
    const RegionGrid& grid;
    RegionPrograms& programs;
    std::uint32_t surface_word;
    bool cull_back;
};

bool covers_a_centre(const std::array<Edge, 3>& edges, const PixelBox& box) {
    for (int y = box.y0; y <= box.y1; ++y) {
        for (int x = box.x0; x <= box.x1; ++x) {
            std::int64_t signs = 0;
            for (const Edge& e : edges) {
                signs |= e.a * x + e.b * y + e.c;
            }
            if (signs >= 0) {
                return true;
            }
        }
    }
    return false;
}

/// Emits the triangle into the region in this column and row. Returns 1, or 0 if it is not there.
std::uint32_t emit(const std::array<Edge, 3>& edges, const AttributePlanes& planes, int column,
                   int row, const Target& target) {
    const int x0 = column << region_bits, y0 = row << region_bits;
    std::array<RegionEdge, 3> here;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::optional<RegionEdge> edge = region_edge(edges[k], x0, y0);
        if (!edge) {
            return 0;
        }
        here[k] = *edge;
    }
    const int region = target.grid.first_region + row * target.grid.columns + column;
    std::uint32_t* words =
        target.programs.append(static_cast<std::size_t>(region), isa::triangle::word_count);
    write_triangle(here, planes, x0, y0, target.surface_word, words);
    return 1;
}

/// Culls, sets up and emits one triangle with no corner outside. Returns in how many regions.
std::uint32_t draw_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c,
                            const Target& target) {
    const PixelBox box = pixel_box(a, b, c, target.grid);
    if (box.empty()) {
        return 0;
    }
    const std::int64_t det = determinant(a, b, c);
    // Counter-clockwise to the eye is negative, as y runs down.
    if (det == 0 || (det > 0 && target.cull_back)) {
        return 0;
    }
    const ScreenVertex& v1 = det > 0 ? b : c;
    const ScreenVertex& v2 = det > 0 ? c : b;
    const std::array<Edge, 3> edges = edges_of(a, v1, v2);
    if ((box.x1 - box.x0 + 1) * (box.y1 - box.y0 + 1) <= searched_px &&
        !covers_a_centre(edges, box)) {
        return 0;
    }
    const AttributePlanes planes = planes_of(a, v1, v2, det > 0 ? det : -det);
    std::uint32_t emitted = 0;
    for (int row = box.y0 >> region_bits; row <= box.y1 >> region_bits; ++row) {
        for (int column = box.x0 >> region_bits; column <= box.x1 >> region_bits; ++column) {
            emitted += emit(edges, planes, column, row, target);
        }
    }
    return emitted;
}

}  // namespace

DrawCounts draw_slab(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                     const SurfaceStyle& style, DrawScratch& scratch, RegionPrograms& programs) {
    assert(style.index < max_surfaces);
    scratch.vertices.resize(mesh.vertices.size());
    transform(mesh.vertices, projection, scratch.vertices);

    const Target target{grid, programs, isa::triangle::surface_word(style.index + 1U),
                        style.cull_back};
    DrawCounts counts;
    counts.triangles_in = static_cast<std::uint32_t>(mesh.indices.size() / 3);
    const bool origins = programs.keeps_origins() && !mesh.origins.empty();
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        if (is_hidden(style.hidden, i / 3)) {
            continue;
        }
        const std::uint32_t* index = &mesh.indices[i];
        const ScreenVertex& a = scratch.vertices[index[0]];
        const ScreenVertex& b = scratch.vertices[index[1]];
        const ScreenVertex& c = scratch.vertices[index[2]];
        if (origins) {
            programs.set_origin(mesh.origins[i / 3]);
        }
        if ((a.outside | b.outside | c.outside) == 0) [[likely]] {
            counts.triangles_out += draw_triangle(a, b, c, target);
            continue;
        }
        if ((a.outside & b.outside & c.outside) != 0) {
            continue;
        }
        const auto vertex = [&](std::size_t k) { return &mesh.vertices[index[k]]; };
        clip_triangle({vertex(0), vertex(1), vertex(2)}, {&a, &b, &c}, projection, scratch.polygon);
        for (std::size_t k = 2; k < scratch.polygon.size(); ++k) {
            if (origins) {
                Origin origin = mesh.origins[i / 3];
                origin.piece = static_cast<std::uint8_t>(k - 2);
                programs.set_origin(origin);
            }
            counts.triangles_out += draw_triangle(scratch.polygon[0], scratch.polygon[k - 1],
                                                  scratch.polygon[k], target);
        }
    }
    return counts;
}

std::uint32_t draw_screen_triangle(const ScreenVertex& a, const ScreenVertex& b,
                                   const ScreenVertex& c, const RegionGrid& grid,
                                   const SurfaceStyle& style, RegionPrograms& programs) {
    assert(style.index < max_surfaces);
    return draw_triangle(
        a, b, c, {grid, programs, isa::triangle::surface_word(style.index + 1U), style.cull_back});
}

}  // namespace pxpl5::gp
