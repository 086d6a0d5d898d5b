#include "host/surface/parts/own_volume.hpp"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

namespace pxpl5::host {

namespace {

bool meet(const BoxMm& a, const BoxMm& b) {
    return glm::all(glm::lessThanEqual(a.low, b.high)) &&
           glm::all(glm::lessThanEqual(b.low, a.high));
}

}  // namespace

OwnVolume own_volume(const MeshComponents& parts, std::size_t component) {
    const std::vector<MeshComponent>& all = parts.components;
    const auto volume_mm3 = [&](std::size_t i) { return all[i].volume_mm3.value_or(0); };
    const MeshComponent& asked = all[component];
    if (asked.cavity_of && !asked.closed && volume_mm3(*asked.cavity_of) < 0) {
        component = *asked.cavity_of;
    }
    const MeshComponent& own = all[component];
    // A component with holes is no known cavity, and next to one no open component has cavities.
    const bool is_unknown =
        !own.cavity && std::ranges::any_of(all, [&](const MeshComponent& other) {
            return !other.closed_but_for_border &&
                   (!own.closed || meet(other.bounds_mm, own.bounds_mm));
        });
    if (is_unknown) {
        return {component, std::nullopt};
    }
    if (own.cavity) {
        return {component, std::abs(volume_mm3(component))};
    }
    double sum_mm3 = volume_mm3(component);
    if (!own.closed && sum_mm3 < 0) {
        sum_mm3 += parts.box_mm3;  // What is not outside.
    }
    for (std::size_t i = 0; i < all.size(); ++i) {
        sum_mm3 += all[i].cavity_of == component ? volume_mm3(i) : 0;
    }
    return {component, std::max(0.0, sum_mm3)};
}

}  // namespace pxpl5::host
