// The shape, scalar type and place of a volume.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <vector>

#include "ringbus/rules/voxels.hpp"

namespace pxpl5::gp {

/// Shape, type and place of a volume. Voxel (x, y, z) lies at the grid position (x, y, place(z)).
struct VolumeShape {
    int nx = 0, ny = 0, nz = 0;  ///< Voxels; each >= 2.
    Scalar type = Scalar::int16;
    glm::dmat4 voxel_to_patient{1.0};    ///< Grid position to millimeters (LPS).
    double minimum = 0, maximum = 0;     ///< Over all voxels.
    int slabs_per_set = 1;               ///< Neighboring slabs that belong to one GP.
    std::vector<double> slice_places{};  ///< nz, ascending; empty if slice z lies at z.
    std::vector<int> gap_slabs{};        ///< Across missing slices, ascending.
    GradientKernel gradient = GradientKernel::central;

    int slab_count() const { return nz - 1; }
    double place(int z) const {
        return slice_places.empty() ? z : slice_places[static_cast<std::size_t>(z)];
    }
    /// Returns the distance from slice `slab` to the next one in the grid.
    double height(int slab) const { return place(slab + 1) - place(slab); }
    /// Returns whether the GPs store gradients beside the voxels, as in the paper. Otherwise a
    /// gradient is estimated when a vertex needs it. Large volumes use larger sets, because they
    /// would not fit beside their gradients.
    bool holds_gradients() const { return slabs_per_set == 1; }
    std::size_t slice_voxels() const {
        return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
    }
};

}  // namespace pxpl5::gp
