// Area and enclosed volume of a slab's triangles, in the patient.
#pragma once

#include "gp_firmware/surface/mesh.hpp"
#include "gp_firmware/volume/slice.hpp"
#include "isa/contract/vector_target.hpp"

namespace pxpl5::gp {

/// What measure() sums, triangle by triangle.
struct TriangleSums {
    double doubled_area = 0, flux_by_six = 0;
};

/// Sets mesh.counts.area_mm2 and .volume_mm3, summed in the order of the triangles.
///
/// The volume is that of the inside between the two slices, closed by the volume's own faces where
/// the surface leaves it: by Gauss's theorem the flux of (x, 0, 0) through the triangles, and
/// through the one face of the volume where that flux is not zero.
///
/// inside_of_last_face   As of border.hpp.
/// Vectors take several triangles at a time, by the operations that each would take alone.
void measure(const VolumeShape& shape, double inside_of_last_face, SlabMesh& mesh,
             isa::VectorTarget target);

}  // namespace pxpl5::gp
