#include "gp_firmware/render/draw_slab.hpp"

#include <array>
#include <bit>
#include <cassert>
#include <chrono>
#include <optional>

#include "generated/vocabulary.hpp"
#include "gp_firmware/geometry/clip.hpp"
#include "gp_firmware/render/plane_setup.hpp"
#include "gp_firmware/render/select_triangles.hpp"
#include "gp_firmware/render/triangle_program.hpp"
#include "isa/contract/triangle_shape.hpp"

namespace pxpl5::gp {

namespace {

/// Values that all triangles of a slab share.
struct Target {
    const RegionGrid& grid;
    RegionPrograms& programs;
    std::uint32_t surface_word;
    bool cull_back;
};

bool covers_a_center(const std::array<Edge, 3>& edges, const PixelBox& box) {
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

/// Returns the edges for the region whose first pixel is (x0, y0); nothing if the triangle does not
/// touch the region.
std::optional<std::array<RegionEdge, 3>> region_edges(const std::array<Edge, 3>& edges, int x0,
                                                      int y0) {
    std::array<RegionEdge, 3> here;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::optional<RegionEdge> edge = region_edge(edges[k], x0, y0);
        if (!edge) {
            return std::nullopt;
        }
        here[k] = *edge;
    }
    return here;
}

/// Calls put(region, edges for it, x0, y0) for every region that the triangle touches. Returns the
/// number of regions.
template <typename Put>
std::uint32_t for_regions(const std::array<Edge, 3>& edges, const PixelBox& box,
                          const RegionGrid& grid, const Put& put) {
    std::uint32_t count = 0;
    for (int row = box.y0 >> region_bits; row <= box.y1 >> region_bits; ++row) {
        for (int column = box.x0 >> region_bits; column <= box.x1 >> region_bits; ++column) {
            const int x0 = column << region_bits, y0 = row << region_bits;
            if (const auto here = region_edges(edges, x0, y0)) {
                const int region = grid.first_region + row * grid.columns + column;
                put(static_cast<std::size_t>(region), *here, x0, y0);
                ++count;
            }
        }
    }
    return count;
}

/// Culls, sets up and emits one triangle that has no corner outside. Returns the number of regions.
std::uint32_t draw_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c,
                            const Target& target) {
    const PixelBox box = pixel_box(a, b, c, target.grid);
    if (box.empty()) {
        return 0;
    }
    const std::int64_t det = determinant(a, b, c);
    // Triangles counter-clockwise to the eye have a negative determinant, because y points down.
    if (det == 0 || (det > 0 && target.cull_back)) {
        return 0;
    }
    const ScreenVertex& v1 = det > 0 ? b : c;
    const ScreenVertex& v2 = det > 0 ? c : b;
    const std::array<Edge, 3> edges = edges_of(a, v1, v2);
    if ((box.x1 - box.x0 + 1) * (box.y1 - box.y0 + 1) <= searched_px &&
        !covers_a_center(edges, box)) {
        return 0;
    }
    const AttributePlanes planes = planes_of(a, v1, v2, det > 0 ? det : -det);
    return for_regions(
        edges, box, target.grid,
        [&](std::size_t region, const std::array<RegionEdge, 3>& here, int x0, int y0) {
            write_triangle(here, planes, x0, y0, target.surface_word,
                           target.programs.append(region, isa::triangle::word_count));
        });
}

/// One slab during drawing. Vector code selects triangles; the functions here draw each of them.
class SlabDrawing {
  public:
    SlabDrawing(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                const SurfaceStyle& style, DrawScratch& scratch, RegionPrograms& programs)
        : mesh_(mesh),
          projection_(projection),
          scratch_(scratch),
          target_{grid, programs, isa::triangle::surface_word(style.index + 1U), style.cull_back},
          hidden_(style.hidden),
          origins_(programs.keeps_origins() && !mesh.origins.empty()) {}

    DrawCounts draw(VectorTarget vectors);

  private:
    ScreenSlab transformed(VectorTarget vectors);
    std::uint32_t draw_one(std::size_t triangle, std::uint32_t region, const NamedTriangle& named);
    std::uint32_t add_to_many(const NamedTriangle& named);
    std::uint32_t draw_by_itself(std::size_t triangle);

    const SlabMesh& mesh_;
    const Projection& projection_;
    DrawScratch& scratch_;
    Target target_;
    std::span<const std::uint8_t> hidden_;
    bool origins_;
    const GridVertex* vertices_ = nullptr;
};

ScreenSlab SlabDrawing::transformed(VectorTarget vectors) {
    const std::size_t vertex_count = mesh_.vertices.size();
    scratch_.outside.resize(vertex_count);
    ScreenSlab slab;
    slab.first_corner = static_cast<std::uint32_t>(target_.programs.corner_count());
    GridVertex* corners = target_.programs.add_corners(vertex_count);
    const bool all_inside = transform(mesh_.vertices, projection_, {corners, vertex_count},
                                      scratch_.outside, vectors) == 0;
    slab.vertices = vertices_ = corners;
    slab.indices = mesh_.indices;
    slab.outside = all_inside ? nullptr : scratch_.outside.data();
    slab.surface_word = target_.surface_word;
    slab.cull_back = target_.cull_back;
    return slab;
}

DrawCounts SlabDrawing::draw(VectorTarget vectors) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    const ScreenSlab slab = transformed(vectors);
    DrawCounts counts;
    counts.transform_ns = static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start).count());

    const SelectTriangles select = select_triangles(vectors);
    Selection selection;
    counts.triangles_in = static_cast<std::uint32_t>(mesh_.indices.size() / 3);
    for (std::size_t first = 0; first < counts.triangles_in; first += Selection::size) {
        select(slab, target_.grid, first, selection);
        for (std::uint64_t rest = selection.chosen; rest != 0; rest &= rest - 1) {
            const auto i = static_cast<std::size_t>(std::countr_zero(rest));
            const std::uint32_t emitted =
                draw_one(first + i, selection.regions[i], selection.triangles[i]);
            counts.triangles_out += emitted;
            counts.drawn += emitted > 0 ? 1 : 0;
        }
    }
    return counts;
}

std::uint32_t SlabDrawing::draw_one(std::size_t triangle, std::uint32_t region,
                                    const NamedTriangle& named) {
    if (is_hidden(hidden_, triangle)) {
        return 0;
    }
    if (origins_) {
        target_.programs.set_origin(mesh_.origins[triangle]);
    }
    if (region == Selection::many_regions) {
        return add_to_many(named);
    }
    if (region == Selection::by_itself) {
        return draw_by_itself(triangle);
    }
    target_.programs.add(region, named);
    return 1;
}

std::uint32_t SlabDrawing::add_to_many(const NamedTriangle& named) {
    const auto corners = target_.programs.corners();
    const ScreenVertex v0 = screen_vertex(corners[named.v0]), v1 = screen_vertex(corners[named.v1]),
                       v2 = screen_vertex(corners[named.v2]);
    return for_regions(edges_of(v0, v1, v2), pixel_box(v0, v1, v2, target_.grid), target_.grid,
                       [&](std::size_t region, const std::array<RegionEdge, 3>&, int, int) {
                           target_.programs.add(region, named);
                       });
}

/// Clips the triangle if a corner is outside, and draws the remaining pieces.
std::uint32_t SlabDrawing::draw_by_itself(std::size_t triangle) {
    const std::uint32_t* index = &mesh_.indices[3 * triangle];
    std::array<ScreenVertex, 3> screen;
    for (std::size_t k = 0; k < 3; ++k) {
        screen[k] = screen_vertex(vertices_[index[k]], scratch_.outside[index[k]]);
    }
    const auto& [a, b, c] = screen;
    if ((a.outside | b.outside | c.outside) == 0) {
        return draw_triangle(a, b, c, target_);
    }
    const auto vertex = [&](std::size_t k) { return &mesh_.vertices[index[k]]; };
    clip_triangle({vertex(0), vertex(1), vertex(2)}, {&a, &b, &c}, projection_, scratch_.polygon);
    std::uint32_t emitted = 0;
    for (std::size_t k = 2; k < scratch_.polygon.size(); ++k) {
        if (origins_) {
            Origin origin = mesh_.origins[triangle];
            origin.piece = static_cast<std::uint8_t>(k - 2);
            target_.programs.set_origin(origin);
        }
        emitted += draw_triangle(scratch_.polygon[0], scratch_.polygon[k - 1], scratch_.polygon[k],
                                 target_);
    }
    return emitted;
}

}  // namespace

DrawCounts draw_slab(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                     const SurfaceStyle& style, DrawScratch& scratch, RegionPrograms& programs,
                     VectorTarget vectors) {
    assert(style.index < max_surfaces);
    return SlabDrawing(mesh, projection, grid, style, scratch, programs).draw(vectors);
}

std::uint32_t draw_screen_triangle(const ScreenVertex& a, const ScreenVertex& b,
                                   const ScreenVertex& c, const RegionGrid& grid,
                                   const SurfaceStyle& style, RegionPrograms& programs) {
    assert(style.index < max_surfaces);
    return draw_triangle(
        a, b, c, {grid, programs, isa::triangle::surface_word(style.index + 1U), style.cull_back});
}

}  // namespace pxpl5::gp
