// Slice planes of a frame: the last entries of its list of surfaces stand for them. Plain, for
// every stage. `draw` is a DrawFrame of a checked message: it has at least as many entries as
// planes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace pxpl5::bus {

/// Returns the number of a frame's slice planes.
std::size_t plane_count(const auto& draw) {
    return draw.planes() == nullptr ? 0 : draw.planes()->size();
}

/// Returns the index of the first plane's entry in the list of surfaces.
std::size_t first_plane(const auto& draw) {
    return draw.surfaces()->size() - plane_count(draw);
}

/// Returns the plane that an entry stands for; null if the entry is a surface.
/// index  In the list of surfaces; one beyond its end is no plane.
auto* plane_at(const auto& draw, std::size_t index) {
    const std::size_t first = first_plane(draw);
    return index < first || index >= draw.surfaces()->size()
               ? nullptr
               : draw.planes()->Get(static_cast<std::uint32_t>(index - first));
}

}  // namespace pxpl5::bus
