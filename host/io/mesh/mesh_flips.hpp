// Triangles without area, removed by flipping edges.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/io/mesh/mesh_export.hpp"

namespace pxpl5::host::io {

/// Whether the corners of a triangle lie on one line. Exact: the certificate calls the same
/// triangles degenerate.
bool is_flat(std::span<const MeshPoint> vertices, const std::array<std::uint32_t, 3>& triangle);

/// Removes triangles without area. The middle corner of such a triangle lies on its longest side,
/// so the triangle behind that side is split there in two. The places covered by the surface, its
/// vertices and the number of triangles stay. A triangle stays flat if its longest side has not
/// exactly one other triangle, or if the split would repeat an edge.
///
/// vertices  Each at its own place.
/// indices   3 per triangle.
void flip_flat_triangles(std::span<const MeshPoint> vertices, std::vector<std::uint32_t>& indices);

}  // namespace pxpl5::host::io
