#include "gp_firmware/surface/measure.hpp"

#include <cmath>
#include <glm/glm.hpp>

namespace pxpl5::gp {

void measure(const VolumeShape& shape, double inside_of_last_face, SlabMesh& mesh) {
    const glm::dmat3 m(shape.voxel_to_patient);
    // (M a) x (M b) = C (a x b) with the cofactors C, also where M mirrors.
    const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                               glm::cross(m[0], m[1]));
    double doubled_area = 0, flux_by_six = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a(mesh.vertices[mesh.indices[i]].p_voxel);
        const glm::dvec3 b(mesh.vertices[mesh.indices[i + 1]].p_voxel);
        const glm::dvec3 c(mesh.vertices[mesh.indices[i + 2]].p_voxel);
        const glm::dvec3 doubled_normal = glm::cross(b - a, c - a);
        const glm::dvec3 normal = cofactors * doubled_normal;
        doubled_area += std::sqrt(glm::dot(normal, normal));
        flux_by_six += (a.x + b.x + c.x) * doubled_normal.x;
    }
    // Triangles are wound for the patient: where M mirrors, they face inwards among the voxels.
    const double scale = glm::determinant(m);
    mesh.counts.area_mm2 = doubled_area / 2;
    mesh.counts.volume_mm3 =
        scale * flux_by_six / 6 + std::abs(scale) * (shape.nx - 1) * inside_of_last_face;
}

}  // namespace pxpl5::gp
