// The only file that includes meshoptimizer.
#include "host/io/mesh_simplify.hpp"

#include <meshoptimizer.h>

#include <cassert>
#include <cmath>
#include <limits>

namespace pxpl5::host::io {

SimplifiedSurface simplify(const MeshSurface& surface, double keep) {
    assert(keep > 0 && keep <= 1);
    static_assert(sizeof(MeshPoint) == 6 * sizeof(float));
    const auto target = static_cast<std::size_t>(
        std::llround(static_cast<double>(surface.indices.size() / 3) * keep));
    const float* positions = &surface.vertices.data()->p_mm.x;
    SimplifiedSurface result;
    result.indices.resize(surface.indices.size());
    float error = 0;  // Of the surface's extent.
    const std::size_t left =
        meshopt_simplify(result.indices.data(), surface.indices.data(), surface.indices.size(),
                         positions, surface.vertices.size(), sizeof(MeshPoint), 3 * target,
                         std::numeric_limits<float>::max(), meshopt_SimplifyLockBorder, &error);
    result.indices.resize(left);
    result.indices.shrink_to_fit();
    result.moved_mm =
        static_cast<double>(error) * static_cast<double>(meshopt_simplifyScale(
                                         positions, surface.vertices.size(), sizeof(MeshPoint)));
    constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> number(surface.vertices.size(), unused);
    for (const std::uint32_t index : result.indices) {
        number[index] = 0;
    }
    for (std::size_t index = 0; index < number.size(); ++index) {
        if (number[index] != unused) {
            number[index] = static_cast<std::uint32_t>(result.vertices.size());
            result.vertices.push_back(surface.vertices[index]);
        }
    }
    for (std::uint32_t& index : result.indices) {
        index = number[index];
    }
    return result;
}

}  // namespace pxpl5::host::io
