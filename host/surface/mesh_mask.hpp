// Which triangles of a surface the GPs leave out of the picture.
#pragma once

#include <cstdint>

#include "host/surface/components.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// MaskSurface for all GPs; slabs that are shown whole are left out.
/// shown  Per triangle of `mesh` (asserted).
bus::Payload mask_message(const WeldedMesh& mesh, const Shown& shown, std::uint16_t surface,
                          std::uint32_t revision);

}  // namespace pxpl5::host
