// Closes a surface at the border of the volume.
#pragma once

#include "host/surface/volume_grid.hpp"
#include "host/surface/welded_mesh.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Covers the part of the volume's six faces that lies inside the surface. The new triangles join
/// the surface's own open edges there to the inside voxels of the faces, which become vertices.
/// Holes away from the border stay.
///
/// mesh      In the grid, with keys. Afterwards new vertices have keys beyond the volume's.
/// isovalue  Of the surface: tells on which side of the surface a voxel lies.
void cap_at_border(WeldedMesh& mesh, const Volume& volume, double isovalue);

}  // namespace pxpl5::host
