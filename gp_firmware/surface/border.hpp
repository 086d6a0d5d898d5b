// Where a surface leaves the volume: the part of the volume's last x face that lies inside.
#pragma once

#include "gp_firmware/volume/slice_store.hpp"

namespace pxpl5::gp {

/// Area inside the surface on the face x = nx - 1 between slices slab and slab + 1, in the grid
/// (0 .. (ny - 1) * height(slab)): linear along the cells' edges, inside corners apart where a face
/// is ambiguous.
double inside_of_last_face(const SliceStore& store, int slab, double isovalue);

}  // namespace pxpl5::gp
