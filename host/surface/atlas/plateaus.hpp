// Where the choice of an isovalue matters little.
#pragma once

#include <span>
#include <vector>

#include "host/surface/atlas/atlas_chart.hpp"

namespace pxpl5::host {

/// Over how much of all rows' range of isovalues a plateau reaches at least.
inline constexpr double least_plateau_width = 0.04;
/// How much triangles and volume may change over the least width, as a fraction.
inline constexpr double greatest_plateau_change = 0.05;

/// Ranges of isovalues over which the surface stays about the same: made up of stretches of least
/// width across each of which neither the triangles nor the volume change by more than
/// greatest_plateau_change. Over wider plateaus small changes may add up.
/// rows     Ascending by isovalue.
/// Returns  Ascending, apart from each other.
std::vector<AtlasPlateau> find_plateaus(std::span<const AtlasRow> rows);

}  // namespace pxpl5::host
