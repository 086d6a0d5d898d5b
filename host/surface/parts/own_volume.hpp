// The volume of one part of a surface.
#pragma once

#include <cstddef>
#include <optional>

#include "host/surface/components.hpp"

namespace pxpl5::host {

/// A component as a body.
struct OwnVolume {
    /// The component that was asked for. If that is the second face of a slab, the first one.
    std::size_t component = 0;
    /// The volume that a cavity's wall encloses, or that another component encloses without its
    /// cavities. The faces of the volume close an open one. None if holes leave it unknown.
    std::optional<double> volume_mm3;
};
OwnVolume own_volume(const MeshComponents& parts, std::size_t component);

}  // namespace pxpl5::host
