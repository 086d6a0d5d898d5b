// The grid of a volume, which a surface's vertices lie in, and its place in the patient.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// A volume without its values.
struct VolumeGrid {
    int nx = 0, ny = 0, nz = 0;  ///< Voxels; each >= 2.
    glm::dmat4 voxel_to_patient{1.0};
    std::vector<double> slice_places;  ///< Same as in Volume.

    std::size_t slab_count() const { return static_cast<std::size_t>(nz) - 1; }
    std::size_t slice_voxels() const {
        return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
    }
    /// z of a slice in the grid.
    double place(int slice) const {
        return slice_places.empty() ? slice : slice_places[static_cast<std::size_t>(slice)];
    }
    glm::dvec3 p_mm(glm::dvec3 p_grid) const {
        return glm::dvec3(voxel_to_patient * glm::dvec4(p_grid, 1.0));
    }
};

VolumeGrid grid_of(const Volume& volume);

/// Where a vertex lies by its key: on the edge that leaves a voxel along an axis, or, axis 3,
/// within the cell at the voxel.
struct EdgePlace {
    std::array<int, 3> voxel{};  ///< The edge's lower end, or the cell's lowest corner.
    int axis = 0;                ///< 0..2; 3 = cell center.
};
EdgePlace edge_place(std::uint64_t key, const VolumeGrid& grid);

/// Takes the cross product of two differences in the grid to that in millimeters, also where
/// voxel_to_patient mirrors.
glm::dmat3 cofactors(const VolumeGrid& grid);

/// A box that grows.
struct BoxMm {
    glm::dvec3 low{0}, high{0};
    bool empty = true;
    void add(glm::dvec3 p_mm);
};

}  // namespace pxpl5::host
