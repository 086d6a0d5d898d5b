// Draw slab: the whole way from one slab's triangles to instruction words in regions.
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

inline constexpr std::size_t max_surfaces = 255;  ///< Of one frame: the pixel has 8 bits for them.

/// How a surface is drawn.
struct SurfaceStyle {
    std::uint16_t index = 0;  ///< In the frame's list; the pixel's surface field is index + 1.
    bool cull_back = false;   ///< Leaves out triangles that turn their back to the eye.
    /// Of the slab that is drawn: bit t % 8 of byte t / 8 hides triangle t; empty hides none.
    std::span<const std::uint8_t> hidden{};
};

/// Whether a mask as SurfaceStyle::hidden hides the slab's triangle.
inline bool is_hidden(std::span<const std::uint8_t> hidden, std::size_t triangle) {
    return !hidden.empty() && (hidden[triangle / 8] >> triangle % 8 & 1) != 0;
}

/// Buffers kept from slab to slab, so that drawing allocates nothing.
struct DrawScratch {
    std::vector<std::uint32_t> outside;  ///< Bits of the slab's vertices.
    std::vector<ScreenVertex> polygon;
};

struct DrawCounts {
    std::uint32_t triangles_in = 0;   ///< Before culling.
    std::uint32_t triangles_out = 0;  ///< Emitted, over all regions.
    std::uint32_t drawn = 0;          ///< Of triangles_in, those in any region.
    std::uint64_t transform_ns = 0;   ///< Wall time that transform() took of the whole.
};

/// Draws one slab into one view's regions. The caller has called begin_slab().
DrawCounts draw_slab(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                     const SurfaceStyle& style, DrawScratch& scratch, RegionPrograms& programs,
                     isa::VectorTarget vectors = isa::process_target());

/// Draws one triangle of the screen with no corner outside. Returns in how many regions.
std::uint32_t draw_screen_triangle(const ScreenVertex& a, const ScreenVertex& b,
                                   const ScreenVertex& c, const RegionGrid& grid,
                                   const SurfaceStyle& style, RegionPrograms& programs);

}  // namespace pxpl5::gp
