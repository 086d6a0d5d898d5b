// How many holes a surface's open edges make.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "host/surface/mesh_measure.hpp"

namespace pxpl5::host {

using VertexPair = std::array<std::uint32_t, 2>;

/// Open edges that meet at a vertex bound one hole; where more than two meet, those of one face of
/// a cell do: neighbors that decide a face differently leave four open edges around it, and such
/// faces may touch.
/// edges    Open, off the volume's border.
/// middles  Of all vertices.
std::int64_t count_holes(std::span<const VertexPair> edges, std::span<const DoubledMiddle> middles);

}  // namespace pxpl5::host
