// How many components the `watertight` surface has at many isovalues, without extracting any.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// At one isovalue.
struct ComponentCounts {
    std::uint32_t inside = 0;   ///< Groups of inside voxels, joined over the 6 neighbors.
    std::uint32_t outside = 0;  ///< Groups of outside voxels, joined over 18 neighbors.
    /// Pieces of surface. The box has no hole, so each piece parts it in two: groups and pieces
    /// make a tree.
    std::uint32_t surface() const { return inside + outside - 1; }
};

/// Counts at all isovalues at once. A voxel is inside if value >= isovalue; NaN is outside.
/// isovalues  Ascending, at most 65534 (both are asserted).
/// Returns    One per isovalue.
/// Throws     RequestError for fewer than 2 voxels along an axis, or more than 2^32 in all.
/// Memory     6 bytes per voxel besides the volume, and 4 for each saddle: a fifth of the voxels in
///            noise.
/// Source     The pairing of 6 with 18 neighbors is Kong & Rosenfeld's (Digital topology, 1989);
///            that `watertight` follows it, see README.md. The sweep is Kruskal's algorithm; that
///            only saddles must wait for their turn is ours.
std::vector<ComponentCounts> count_components(const Volume& volume,
                                              std::span<const double> isovalues);

}  // namespace pxpl5::host
