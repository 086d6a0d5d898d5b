// How many components the `watertight` surface has at many isovalues, without extracting any.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/volume.hpp"

namespace pxpl5::host {

/// At one isovalue.
struct ComponentCounts {
    std::uint32_t inside = 0;   ///< Groups of inside voxels, joined over the 6 neighbours.
    std::uint32_t outside = 0;  ///< Of outside voxels, joined over the 18: diagonals of faces too.
    /// Pieces of surface. The box has no hole, so each piece parts it in two: groups and pieces
    /// make a tree.
    std::uint32_t surface() const { return inside + outside - 1; }
};

/// Sweeps once over the volume. A voxel is inside if value >= isovalue; NaN is outside.
/// isovalues  Ascending (asserted), at most 65534 (asserted).
/// Returns    One per isovalue.
/// Throws     RequestError for more than 2^32 voxels.
/// Memory     6 bytes per voxel besides the volume.
/// Source     The pairing of 6 with 18 neighbours is Kong & Rosenfeld's (Digital topology, 1989);
///            that `watertight` follows it, see README.md; the sweep is Kruskal's algorithm.
std::vector<ComponentCounts> count_components(const Volume& volume,
                                              std::span<const double> isovalues);

}  // namespace pxpl5::host
