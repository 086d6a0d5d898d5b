#include "host/scene/slice_places.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

namespace pxpl5::host {

double place_of_slice(double slice, std::span<const double> places) {
    if (places.empty()) {
        return slice;
    }
    assert(places.size() >= 2);
    const double last_slab = static_cast<double>(places.size() - 2);
    const double slab = std::clamp(std::floor(slice), 0.0, last_slab);
    const auto k = static_cast<std::size_t>(slab);
    return places[k] + (slice - slab) * (places[k + 1] - places[k]);
}

double slice_of_place(double place, std::span<const double> places) {
    if (places.empty()) {
        return place;
    }
    assert(places.size() >= 2);
    const auto above = std::upper_bound(places.begin() + 1, places.end() - 1, place);
    const auto k = static_cast<std::size_t>(above - places.begin()) - 1;
    return static_cast<double>(k) + (place - places[k]) / (places[k + 1] - places[k]);
}

std::array<glm::dvec3, 8> corners_mm(const Volume& volume, const glm::ivec3& first,
                                     const glm::ivec3& last) {
    std::array<glm::dvec3, 8> corners{};
    for (unsigned corner = 0; corner < 8; ++corner) {
        const auto end = [&](int axis) {
            return (corner >> static_cast<unsigned>(axis) & 1U) != 0 ? last[axis] : first[axis];
        };
        const double place = place_of_slice(end(2), volume.slice_places);
        corners[corner] =
            glm::dvec3(volume.voxel_to_patient * glm::dvec4(end(0), end(1), place, 1));
    }
    return corners;
}

}  // namespace pxpl5::host
