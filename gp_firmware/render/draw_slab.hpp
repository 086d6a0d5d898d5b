// Draw slab: turns one slab's triangles into instruction words of regions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/geometry/bin.hpp"
#include "gp_firmware/geometry/transform.hpp"
#include "gp_firmware/render/region_programs.hpp"
#include "gp_firmware/surface/mesh.hpp"

namespace pxpl5::gp {

/// How a surface is drawn.
struct SurfaceStyle {
    std::uint16_t index = 0;  ///< Index in the frame's list. A pixel stores index + 1.
    bool cull_back = false;   ///< Omits triangles that face away from the eye.
    std::span<const std::uint8_t> hidden{};  ///< Mask of the slab, see is_hidden().
};

/// Buffers kept from slab to slab, so that drawing allocates nothing.
struct DrawScratch {
    std::vector<std::uint32_t> outside;  ///< Outside bits of the slab's vertices.
    std::vector<ScreenVertex> polygon;
};

struct DrawCounts {
    std::uint32_t triangles_in = 0;   ///< Triangles before culling.
    std::uint32_t triangles_out = 0;  ///< Triangles emitted, summed over all regions.
    std::uint32_t drawn = 0;          ///< Triangles of triangles_in that are in any region.
    std::uint64_t transform_ns = 0;   ///< Wall time of transform().
    double moved_mm = 0;              ///< No simplified triangle is farther from the exact surface.
};

/// Draws one slab into one view's regions. The caller has called begin_slab().
DrawCounts draw_slab(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                     const SurfaceStyle& style, DrawScratch& scratch, RegionPrograms& programs,
                     VectorTarget vectors = isa::process_target());

/// Draws one triangle of the screen that has no corner outside. Returns the number of its regions.
std::uint32_t draw_screen_triangle(const ScreenVertex& a, const ScreenVertex& b,
                                   const ScreenVertex& c, const RegionGrid& grid,
                                   const SurfaceStyle& style, RegionPrograms& programs);

}  // namespace pxpl5::gp
