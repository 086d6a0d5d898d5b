#include "host/surface/volume_grid.hpp"

#include <glm/glm.hpp>

namespace pxpl5::host {

VolumeGrid grid_of(const Volume& volume) {
    return {volume.nx, volume.ny, volume.nz, volume.voxel_to_patient, volume.slice_places};
}

EdgePlace edge_place(std::uint64_t key, const VolumeGrid& grid) {
    const std::uint64_t voxel = key / 4, slice = grid.slice_voxels();
    const std::uint64_t z = voxel / slice, in_slice = voxel % slice;
    const auto nx = static_cast<std::uint64_t>(grid.nx);
    return {{static_cast<int>(in_slice % nx), static_cast<int>(in_slice / nx), static_cast<int>(z)},
            static_cast<int>(key % 4)};
}

glm::dmat3 cofactors(const VolumeGrid& grid) {
    const glm::dmat3 m(grid.voxel_to_patient);
    // (M a) x (M b) = C (a x b) with the cofactors C, also where M mirrors.
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

void BoxMm::add(glm::dvec3 p_mm) {
    low = empty ? p_mm : glm::min(low, p_mm);
    high = empty ? p_mm : glm::max(high, p_mm);
    empty = false;
}

}  // namespace pxpl5::host
