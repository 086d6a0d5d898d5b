// Decimation: fewer triangles for nearly the same surface.
#pragma once

#include "host/io/mesh/mesh_export.hpp"

namespace pxpl5::host::io {

/// Collapses edges until a share `keep` of the triangles is left, or none can be collapsed without
/// changing how the surface is connected, or without moving it by more than 5 % of its extent.
/// Edges with a triangle on one side alone stay. Vertices at one place become one, and triangles
/// that have no area for that reason go first. Where the result would have an edge of more than two
/// triangles, or fans that share nothing but a vertex, its surroundings keep all their triangles;
/// if that does not help, all triangles stay. Triangles without area are
/// flipped away. Where flip_flat_triangles() leaves some, their surroundings keep all their
/// triangles, too; if that does not help, these triangles stay.
///
/// keep      In [0, 1].
/// error_mm  Above 0: no vertex lies farther from the result. The surroundings of vertices that
///           would lie farther keep all their triangles. If no result is near enough, all
///           triangles stay.
/// Source    Garland and Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH
///           1997, as meshoptimizer has it; the rest ours.
SimplifiedSurface simplify(const MeshSurface& surface, double keep, double error_mm = 0);

}  // namespace pxpl5::host::io
