// A volume in the host's memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

namespace pxpl5::host {

enum class Scalar : std::uint8_t { uint8, int16, uint16, float32 };

constexpr std::size_t size_bytes(Scalar type) {
    return type == Scalar::uint8 ? 1 : type == Scalar::float32 ? 4 : 2;
}

/// Voxels with their place in the patient.
struct Volume {
    std::string name;
    int nx = 0, ny = 0, nz = 0;  ///< Voxels.
    Scalar type = Scalar::int16;
    glm::dmat4 voxel_to_patient{1.0};  ///< Voxel index (x, y, z) to millimetres, LPS.
    double minimum = 0, maximum = 0;   ///< Over all voxels.
    std::vector<std::string> notes;  ///< What a reader should know: conversions, gaps, assumptions.
    std::vector<std::byte> values;   ///< nx * ny * nz, x fastest, little endian, of `type`.
    std::string source;              ///< File, folder or phantom:NAME that it was read from.
    std::uint64_t digest = 0;        ///< FNV-1a over the values; 0 if not known.
};

}  // namespace pxpl5::host
