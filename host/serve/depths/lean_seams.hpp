// The cells of a picture that show two surfaces, one behind the other.
#pragma once

#include "host/serve/depths/lean_depths.hpp"

namespace pxpl5::host::serve {

/// The seams of a picture whose corners are known. A cell shows two surfaces if its depths have a
/// gap of at least seam_depth that is more than half of their range: the depths of one surface,
/// however steep, are spread evenly. A corner of a surface has the depth of the picture's corner,
/// or that of the closest pixel of the surface if the picture's corner lies on another surface.
///
/// depths  As for lean_depths().
/// cells   Those that may be seams, in order. Each shows a surface.
std::vector<Seam> find_seams(const LeanDepths& lean, std::span<const std::uint32_t> depths,
                             std::span<const std::uint32_t> cells);

}  // namespace pxpl5::host::serve
