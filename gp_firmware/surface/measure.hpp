// Area and enclosed volume of a slab's triangles, in the patient.
#pragma once

#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// The sums over triangles that measure() needs.
struct TriangleSums {
    double doubled_area = 0, flux_by_six = 0;
};

/// Sets mesh.counts.area_mm2 and .volume_mm3, summed in the order of the triangles.
///
/// The volume is that of the inside between the two slices; the faces of the scan close it where
/// the surface leaves the scan. By Gauss's theorem, it is the flux of (x, 0, 0) through the
/// triangles and through the one face of the scan where that flux is not zero.
///
/// Vector code handles several triangles at a time, with the operations of a single triangle.
/// inside_of_last_face  The result of the function of that name in border.hpp.
void measure(const VolumeShape& shape, double inside_of_last_face, SlabMesh& mesh,
             VectorTarget target);

}  // namespace pxpl5::gp
