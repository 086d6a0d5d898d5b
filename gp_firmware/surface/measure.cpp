#include "gp_firmware/surface/measure.hpp"

#include <cmath>
#include <glm/glm.hpp>

namespace pxpl5::gp {

void measure(const glm::dmat4& voxel_to_patient, SlabMesh& mesh) {
    const glm::dmat3 m(voxel_to_patient);
    const glm::dvec3 origin(voxel_to_patient[3]);
    // (M a) x (M b) = C (a x b) with the cofactors C, also where M mirrors.
    const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]),
                               glm::cross(m[0], m[1]));
    double doubled_area = 0, volume_by_six = 0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a(mesh.vertices[mesh.indices[i]].p_voxel);
        const glm::dvec3 b(mesh.vertices[mesh.indices[i + 1]].p_voxel);
        const glm::dvec3 c(mesh.vertices[mesh.indices[i + 2]].p_voxel);
        const glm::dvec3 normal = cofactors * glm::cross(b - a, c - a);
        doubled_area += std::sqrt(glm::dot(normal, normal));
        volume_by_six += glm::dot(m * a + origin, normal);
    }
    mesh.counts.area_mm2 = doubled_area / 2;
    mesh.counts.volume_mm3 = volume_by_six / 6;
}

}  // namespace pxpl5::gp
