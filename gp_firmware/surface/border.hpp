// Where a surface leaves the volume: the part of the volume's last x face that lies inside.
#pragma once

#include "gp_firmware/volume/slice_store.hpp"

namespace pxpl5::gp {

/// Area inside the surface on the face x = nx - 1 between slices slab and slab + 1, in the grid
/// (0 .. (ny - 1) * height(slab)): linear along the cells' edges.
/// decides_faces  As of the CaseTable: where a face is ambiguous, inside corners are apart, or, if
///                it decides, joined where the saddle is inside.
double inside_of_last_face(const SliceStore& store, int slab, double isovalue, bool decides_faces);

}  // namespace pxpl5::gp
