// Draw scene: turns a slab's spheres and lines into instruction words of regions.
#pragma once

#include "gp_firmware/render/draw_slab.hpp"

namespace pxpl5::gp {

inline constexpr int line_width_subpixels = 24;  ///< 1.5 pixels at any distance.

/// Draws the slab's spheres, each by its own program. The caller has called begin_slab().
///
/// Returns  The number of spheres, and the number emitted over all regions.
DrawCounts draw_spheres(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                        const SurfaceStyle& style, RegionPrograms& programs);

/// Draws the slab's lines as boxes of two triangles that face the viewer, line_width_subpixels
/// wide and half of that longer at each end, so that the corners of a polyline are closed.
DrawCounts draw_lines(const SlabMesh& mesh, const Projection& projection, const RegionGrid& grid,
                      const SurfaceStyle& style, RegionPrograms& programs);

}  // namespace pxpl5::gp
