// Values of voxels: from the host's memory, or from the GPs if the host keeps a reduced copy.
#pragma once

#include <cstddef>
#include <vector>

#include "host/scene/pick.hpp"
#include "host/scene/slab.hpp"
#include "host/scene/slice.hpp"
#include "host/session/volumes.hpp"

namespace pxpl5::host {

/// A slab and the slice in its middle.
struct Slab {
    Slice middle, values;
    SlabRange range;
};

class Voxels {
  public:
    Voxels(Conversation& conversation, const Volumes& volumes)
        : conversation_(conversation), volumes_(volumes) {}

    /// Returns the slice with all of its voxels. A viewer may cancel the wait for the GPs.
    /// axis   0 x, 1 y, 2 z.
    /// index  0 .. voxels along the axis - 1 (asserted).
    /// Throws RequestError without a volume, after a cancellation and for a GP's fault.
    Slice slice(int axis, int index);
    /// Returns the slab around slice `index`, from all voxels. Fetches one slice after the other,
    /// so that the memory does not depend on the thickness. Arguments and exceptions as for
    /// slice().
    Slab slab(int axis, int index, const SlabWish& wish);
    /// Sets the values of a pick that has none, because the host keeps a reduced copy. Leaves other
    /// picks as they are. Throws as slice().
    void add_values(Pick& pick);

  private:
    /// Returns the values of a box from the GPs, x fastest, then y, then z.
    std::vector<std::byte> fetch(const bus::schema::VoxelBox& box);

    Conversation& conversation_;
    const Volumes& volumes_;
};

}  // namespace pxpl5::host
