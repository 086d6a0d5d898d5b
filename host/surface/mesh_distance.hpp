// How far points lie from a surface.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace pxpl5::host {

/// The distance of each point from the surface.
/// triangles  At least one; indices of `vertices`.
std::vector<double> distances(std::span<const glm::vec3> points,
                              std::span<const glm::vec3> vertices,
                              std::span<const std::array<std::uint32_t, 3>> triangles);

/// The largest of distances().
/// triangles  At least one; indices of `vertices`.
double farthest_distance(std::span<const glm::vec3> points, std::span<const glm::vec3> vertices,
                         std::span<const std::array<std::uint32_t, 3>> triangles);

}  // namespace pxpl5::host
