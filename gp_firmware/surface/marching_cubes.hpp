// Marching cubes in one slab.
#pragma once

#include <cstddef>
#include <functional>

#include "gp_firmware/surface/case_tables.hpp"
#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice_store.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// Extracts the isosurface in slab `slab`: the cells between slices slab and slab + 1.
///
/// A voxel is inside if value >= isovalue; NaN is outside. The same slab of the same volume
/// gives the same bits on every GP.
/// store     A complete store that owns the slab (both are asserted).
/// isovalue  Threshold in the volume's unit.
/// out       Receives the mesh; its capacity is reused.
/// origins   Fills out.origins; otherwise the list is empty.
/// target    A resolved target. It changes the speed, not the result.
/// Throws    std::invalid_argument if isovalue is not finite.
/// Source    Lorensen & Cline 1987; Yoo & Chen, section V. Masks of 64 voxels are ours.
void extract_slab(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
                  SlabMesh& out, bool origins = false, VectorTarget target = isa::process_target());

/// Extracts about `triangles` more. Returns false when the slab is done; then it must not be called
/// again.
using SlabExtraction = std::function<bool(std::size_t triangles)>;

/// Begins extract_slab() in pieces. store, table and out outlive the extraction. Other code must
/// not use out until the slab is done.
SlabExtraction begin_slab(const SliceStore& store, int slab, double isovalue,
                          const CaseTable& table, SlabMesh& out, bool origins = false);

/// Returns the counts of extract_slab(), equal to the last bit, without making normals and keys.
/// scratch  Overwritten; the caller keeps it for its capacity.
SlabCounts measure_slab(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
                        SlabMesh& scratch);

/// Returns the local memory of a slab's mesh. Origins do not count, because recording must not
/// change what fits, and the board had no origins.
std::size_t size_bytes(const SlabMesh& mesh);

}  // namespace pxpl5::gp
