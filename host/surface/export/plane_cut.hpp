// Cuts a surface by a plane and closes the cut; triangles of the area between loops.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <vector>

#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// Keeps the part of a surface where normal . p + offset >= 0. Vertices nearer to the plane than
/// `least` move to that distance on their side, so that no vertex of the cut falls on another.
///
/// plane   Normal of unit length, and offset; same unit as mesh.p_grid.
/// closes  Covers the cut; only where its edges form loops, so not where the surface was open.
void cut_by_plane(WeldedMesh& mesh, const glm::dvec4& plane, double least, bool closes);

struct LoopTriangles {
    /// A corner on the way from corner a to corner b, at this share of the way.
    struct Between {
        std::uint32_t a = 0, b = 0;
        double share = 0;
    };
    /// Indices of the points, and behind them of `added`.
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Between> added;  ///< Only for loops that cross or touch.
};

/// Triangles of the area between loops: counter-clockwise around the area, clockwise around holes
/// in it. Uses each edge of the loops once and each other edge twice, whatever the shape of the
/// loops. Loops that cross or touch give triangles that overlap.
LoopTriangles triangulate_loops(const std::vector<glm::dvec2>& points,
                                const std::vector<std::vector<std::uint32_t>>& loops);

}  // namespace pxpl5::host
