// Facts about a shading: whether it is lawful, and the most light of a pixel.
#pragma once

#include <optional>

#include "renderer_firmware/igc/region_program.hpp"

namespace pxpl5::renderer {

struct Vector {
    double x, y, z;
};

/// Returns the vector with length 1; nothing if it has no length, or no finite one.
std::optional<Vector> normalized(Vector v);

/// Returns the most light that a pixel can have, without rims. A pixel faces some of the lights:
/// their sum is greatest where the normal is the direction of their sum.
double brightest_light(const Shading& shading);

/// Throws std::invalid_argument that names the value and its limit.
void verify(const Shading& shading);

}  // namespace pxpl5::renderer
