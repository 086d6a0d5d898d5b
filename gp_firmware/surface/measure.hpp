// Area and enclosed volume of a slab's triangles, in the patient.
#pragma once

#include <glm/mat4x4.hpp>

#include "gp_firmware/surface/mesh.hpp"

namespace pxpl5::gp {

/// Sets mesh.counts.area_mm2 and .volume_mm3, summed in the order of the triangles.
/// The volume is the slab's part of the sum over cones from the patient's origin: only the total
/// of a closed surface is its enclosed volume.
void measure(const glm::dmat4& voxel_to_patient, SlabMesh& mesh);

}  // namespace pxpl5::gp
