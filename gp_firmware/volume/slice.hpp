// What a Graphics Processor knows of the volume: its shape, and slices with gradients.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <vector>

namespace pxpl5::gp {

enum class Scalar : std::uint8_t { uint8, int16, uint16, float32 };

constexpr std::size_t size_bytes(Scalar type) {
    return type == Scalar::uint8 ? 1 : type == Scalar::float32 ? 4 : 2;
}

/// Shape, type and place of a volume.
struct VolumeShape {
    int nx = 0, ny = 0, nz = 0;  ///< Voxels; each >= 2.
    Scalar type = Scalar::int16;
    glm::dmat4 voxel_to_patient{1.0};  ///< Voxel index to millimetres (LPS).
    double minimum = 0, maximum = 0;   ///< Over all voxels.

    int slab_count() const { return nz - 1; }
    std::size_t slice_voxels() const {
        return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
    }
};

}  // namespace pxpl5::gp
