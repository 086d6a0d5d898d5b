// Which slabs and slices of a volume belong to which Graphics Processor.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::gp {

inline constexpr int max_gp_count = 64;

/// One GP among all.
struct Share {
    int gp_index = 0;  ///< 0 .. gp_count - 1.
    int gp_count = 1;  ///< 1 .. max_gp_count.
};

/// The GP that slab s belongs to: (s / slabs_per_set) mod gp_count.
int owner_of(const VolumeShape& shape, int gp_count, int slab);

/// The slab whose owner's trace holds slice z: z, for the last slice the slab below it.
int slab_that_records(const VolumeShape& shape, int z);

/// Slabs of a GP, ascending, of 0 .. nz - 2.
std::vector<int> slabs_owned(const VolumeShape& shape, Share share);

/// Slices that a GP must be sent, ascending. The rule, which the host follows too:
/// z is needed if z lies in s - 1 .. s + 2 for a slab s of the GP.
/// Source  Yoo & Chen, section IV, "Dataset distribution".
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

/// slabs_per_set that the host would choose for as many GPs: 1 stays 1, larger sets are shared out
/// so that each GP has two at least (host/session/volume_transfer.hpp; a test holds the two
/// together).
int slabs_per_set_with(const VolumeShape& shape, int gp_count);

/// The smallest number of GPs with `memory_bytes` each that can hold the volume, and beside it
/// `surface_bytes` of surfaces spread evenly over the slabs; 0 if max_gp_count do not suffice.
int gp_count_that_would_do(const VolumeShape& shape, std::size_t memory_bytes,
                           std::size_t surface_bytes = 0);

/// "9 GPs would do" or "even 64 GPs would not do": advice for OutOfLocalMemory.
std::string gp_count_advice(const VolumeShape& shape, std::size_t memory_bytes,
                            std::size_t surface_bytes = 0);

}  // namespace pxpl5::gp
