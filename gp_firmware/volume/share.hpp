// Which slabs and slices of a volume belong to which Graphics Processor.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "gp_firmware/volume/slice.hpp"
#include "ringbus/rules/slabs.hpp"

namespace pxpl5::gp {

/// One GP among all.
struct Share {
    int gp_index = 0;  ///< 0 .. gp_count - 1.
    int gp_count = 1;  ///< 1 .. max_nodes_per_role.
};

/// The distribution of the volume's slabs.
SlabSets slab_sets(const VolumeShape& shape, int gp_count);

/// Slabs of a GP, ascending, of 0 .. nz - 2.
std::vector<int> slabs_owned(const VolumeShape& shape, Share share);

/// Slices that a GP must receive, ascending.
std::vector<int> slices_needed(const VolumeShape& shape, Share share);

/// Slices that a GP holds when all have come, ascending: s and s + 1 of its slabs; all that it was
/// sent if gradients are not held.
std::vector<int> slices_kept(const VolumeShape& shape, Share share);

/// Whether slice z is s or s + 1 of a slab s of the GP.
bool is_own(const VolumeShape& shape, Share share, int z);

/// The slice on whose arrival the last gradient that needs slice z can be estimated, so that z
/// may go; nz if z is kept.
int discarded_after(const VolumeShape& shape, Share share, int z);

/// The most local memory that a GP's slices can take while they arrive, and after.
std::size_t peak_bytes(const VolumeShape& shape, Share share);

/// Slices whose values are in memory while the others are compressed: a slab and its neighbors.
inline constexpr std::size_t max_unpacked_slices = 4;
/// A volume that would need better compression than this is refused before its first slice.
inline constexpr double best_packing = 1.0 / 32;
/// The same if slices, with the index of their rows, are compressed to `packing` of their bytes.
std::size_t packed_peak_bytes(const VolumeShape& shape, Share share, double packing);

/// slabs_per_set that the host would choose for `gp_count` GPs. 1 stays 1.
int slabs_per_set_with(const VolumeShape& shape, int gp_count);

/// The smallest number of GPs with `memory_bytes` each that can hold the volume, and beside it
/// `surface_bytes` of surfaces spread evenly over the slabs; 0 if max_nodes_per_role GPs
/// do not suffice. Fewer than `least` are not tried.
/// packing  Share of their bytes that compressed slices take with the index of their rows; 1 if
///          they are not compressed.
int gp_count_that_would_do(const VolumeShape& shape, std::size_t memory_bytes,
                           std::size_t surface_bytes = 0, double packing = 1, int least = 1);

/// "9 GPs would do; ..." or "even 64 GPs would not do; ...": advice for OutOfLocalMemory.
std::string gp_count_advice(const VolumeShape& shape, std::size_t memory_bytes,
                            std::size_t surface_bytes = 0, double packing = 1);

}  // namespace pxpl5::gp
