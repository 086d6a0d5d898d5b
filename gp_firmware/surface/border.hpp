// The part of the volume's last x face that lies inside a surface.
#pragma once

#include "gp_firmware/volume/slice_store.hpp"

namespace pxpl5::gp {

/// Returns the area inside the surface on the face x = nx - 1 between slices slab and slab + 1, in
/// grid units (0 .. (ny - 1) * height(slab)). Values are linear along the cells' edges.
/// decides_faces  CaseTable::decides_faces. If true, inside corners of an ambiguous face are joined
///                where the saddle is inside; otherwise they are always separate.
double inside_of_last_face(const SliceStore& store, int slab, double isovalue, bool decides_faces);

}  // namespace pxpl5::gp
