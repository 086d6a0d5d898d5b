// What a decoder hands over, and its conversion to a Volume of one of our four types.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <string>
#include <vector>

#include "host/volume.hpp"

namespace pxpl5::host::io {

enum class Component : std::uint8_t {
    uint8,
    int8,
    uint16,
    int16,
    uint32,
    int32,
    uint64,
    int64,
    float32,
    float64
};

const char* component_name(Component component);
std::size_t component_bytes(Component component);

/// Voxels as a decoder gives them.
struct Decoded {
    std::array<int, 3> dims{};  ///< Voxels along x, y, z.
    Component component = Component::uint8;
    bool scaled_integers = false;      ///< Stored as integers, scaled on decoding.
    glm::dmat4 voxel_to_patient{1.0};  ///< Voxel index to millimetres, LPS.
    std::vector<std::byte> values;     ///< x fastest, native byte order.
    std::vector<std::string> notes;
};

/// Turns the values into float64, for slices of one volume that differ in type.
void widen_to_float64(Decoded& decoded);

/// Converts to uint8, int16, uint16 or float32, with a note if values changed their type, and finds
/// minimum and maximum over the finite values. Notes what is odd in the place in the patient.
///
/// file     For error texts.
/// Throws   ImportError: limits, no finite value, an affine that is not finite or is singular.
Volume to_volume(const std::string& file, Decoded&& decoded);

}  // namespace pxpl5::host::io
