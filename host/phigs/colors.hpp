// Few colors out of many: a pixel's number of its material has 8 bits.
#pragma once

#include <vector>

#include "host/phigs/content.hpp"

namespace pxpl5::host::phigs {

/// Makes one of materials that are alike in the upper bits of each channel, with as many bits as
/// leave max_surfaces at most. Parts are told their new material; order of first use is kept.
///
/// Returns  Bits kept: 8 if there were few enough, and then nothing is changed.
int merge_colors(std::vector<Material>& materials, std::vector<Part>& parts);

}  // namespace pxpl5::host::phigs
