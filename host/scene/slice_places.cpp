#include "host/scene/slice_places.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>

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

}  // namespace pxpl5::host
