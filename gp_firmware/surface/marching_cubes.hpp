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
/// store     Complete; owns the slab (both are asserted).
/// isovalue  In the volume's unit.
/// out       Overwritten; its capacity is reused.
/// origins   Whether out.origins is filled, too; else it is left empty.
/// target    Resolved. It decides how fast, not what.
/// Throws    std::invalid_argument if isovalue is not finite.
/// Source    Lorensen & Cline 1987; Yoo & Chen, section V. Masks of 64 voxels are ours.
void extract_slab(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
                  SlabMesh& out, bool origins = false,
                  isa::VectorTarget target = isa::process_target());

/// Goes on until about so many triangles more are there. Returns false when the slab is done; it is
/// not called again then.
using SlabExtraction = std::function<bool(std::size_t triangles)>;

/// extract_slab() in pieces. store, table and out outlive it, and out is its own until it is done.
SlabExtraction begin_slab(const SliceStore& store, int slab, double isovalue,
                          const CaseTable& table, SlabMesh& out, bool origins = false);

/// What extract_slab() would count, to the last bit, without normals and keys.
/// scratch  Overwritten; only its capacity is worth keeping.
SlabCounts measure_slab(const SliceStore& store, int slab, double isovalue, const CaseTable& table,
                        SlabMesh& scratch);

/// Local memory that a slab's mesh takes. Origins do not count: recording must not decide what
/// fits, and the board had none.
std::size_t size_bytes(const SlabMesh& mesh);

}  // namespace pxpl5::gp
