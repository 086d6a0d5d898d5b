// Clip: cuts triangles at the near and far planes, the user's clip planes and the guard band.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gp_firmware/geometry/transform.hpp"

namespace pxpl5::gp {

/// Each plane of the view volume and of the user adds at most one corner.
inline constexpr std::size_t max_polygon_corners = 3 + 7 + max_clip_planes;

/// Clips one triangle.
///
/// corners   The triangle's vertices in voxel space, in the order of the mesh.
/// screen    The same vertices after transform().
/// polygon   Receives the convex polygon that remains, in the triangle's winding, all corners with
///           outside == 0; empty if nothing remains. Inside corners are copied from `screen`. A new
///           corner depends only on its edge, not on the edge's direction, so triangles that share
///           an edge still share it.
/// Source    Sutherland & Hodgman 1974.
void clip_triangle(const std::array<const Vertex*, 3>& corners,
                   const std::array<const ScreenVertex*, 3>& screen, const Projection& projection,
                   std::vector<ScreenVertex>& polygon);

}  // namespace pxpl5::gp
