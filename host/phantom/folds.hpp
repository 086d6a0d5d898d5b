// The folds of the brain: a pattern of one wavelength in random directions, as in no two people.
#pragma once

#include "host/phantom/field.hpp"

namespace pxpl5::host::phantom {

/// A labyrinth drawn on an ellipsoid and continued straight inwards and outwards.
struct FoldPattern {
    glm::vec3 center_mm, radius_mm;
    float wavelength_mm;  ///< Two folds and the two furrows beside them.
    std::uint32_t seed;
};

/// Distance to the nearest furrow's middle, about, at each voxel of the box; other voxels keep
/// far_mm.
Field furrow_distance(const Grid& grid, const Box& box, const FoldPattern& pattern);

}  // namespace pxpl5::host::phantom
