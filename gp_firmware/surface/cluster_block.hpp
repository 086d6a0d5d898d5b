// Simplification of a surface by vertex clustering, one block of slabs at a time.
#pragma once

#include <span>

#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice.hpp"
#include "ringbus/rules/slabs.hpp"

namespace pxpl5::gp {

/// Simplifies the mesh of one block. Each vertex moves to the mean of the vertices in its cell of
/// `side` x `side` x `side` voxels. Vertices in the first or last slice of the block, or in a face
/// of the volume, are clustered only with others in the same slice or face. Triangles with two
/// corners in one cell are removed. So are pairs of triangles with the same corners and opposite
/// winding. A closed surface stays closed, but an edge may have more than two triangles.
///
/// Neighbor blocks compute the same bits for the vertices of their common slice, and give them the
/// same keys. The result depends on nothing but the volume, the surface and `side`.
///
/// slabs    All slabs of one block, ascending, complete as extract_slab() makes them (asserted).
///          The last block of a volume may be shorter than block_slabs.
/// hidden   One mask per slab, or empty. The mesh has no hidden triangles, but their vertices take
///          part in the means, so that neighbor blocks agree whatever is hidden.
/// side     Side of a cell in voxels: 2, 4 or 8 (asserted).
/// out      Receives the mesh; out.slab is the first slab. A vertex has the lowest key of its cell.
///          There are no origins. Of the counts, only triangles is set.
/// Returns  The longest distance that a vertex moves, in mm. No point of the simplified mesh is
///          farther from the exact mesh. Parts of the surface within a cell may vanish.
/// Source   Rossignac & Borrel 1993. Cells that respect seams and faces are ours.
double cluster_block(const VolumeShape& shape, std::span<const SlabMesh> slabs,
                     std::span<const SlabMask> hidden, int side, SlabMesh& out);

}  // namespace pxpl5::gp
