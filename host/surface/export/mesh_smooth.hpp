// Smoothing of a surface that keeps its volume.
#pragma once

#include "host/surface/pauses.hpp"
#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"

namespace pxpl5::host {

/// Most passes. Shapes about 20 triangles wide grow with each pass, by 0.5 % after so many.
inline constexpr int max_smoothing = 50;

/// How smoothing has changed a surface.
struct Smoothing {
    double farthest_mm = 0, mean_mm = 0;  ///< Moves of the vertices.
    /// Change of the enclosed volume. It is known for open surfaces too, because their ends stay.
    double volume_mm3 = 0;
};

/// Moves each vertex towards the mean of its neighbors, and then a little farther back, `passes`
/// times. This removes ripples as wide as one or two triangles, and changes larger shapes and the
/// volume little. Vertices at open edges keep their places. New normals follow from the triangles.
///
/// mesh    In the grid. No vertex leaves the box around the surface.
/// pause   What it throws leaves the mesh as it was.
/// Source  Taubin, "A Signal Processing Approach to Fair Surface Design", SIGGRAPH 1995, with
///         lambda 0.5 and mu -0.51.
Smoothing smooth_mesh(WeldedMesh& mesh, const VolumeGrid& grid, int passes,
                      const Pause& pause = {});

}  // namespace pxpl5::host
