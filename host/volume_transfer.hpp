// A volume's way over the ring: to the GPs as slice sets, from the io process as slices.
#pragma once

#include <functional>
#include <vector>

#include "host/digest.hpp"
#include "host/volume.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// The slices that GP `gp_index` of `gp_count` needs, ascending: slab s (between slices s and s +
/// 1) goes to GP s mod gp_count, and its slice set is s-1 .. s+2 as far as they exist. Source: Yoo
/// & Chen, section IV, "Dataset-distribution".
std::vector<int> slices_for_gp(int slice_count, int gp_index, int gp_count);

/// VolumeHeader for `volume` with the given id.
bus::Payload volume_header(const Volume& volume, std::uint32_t id);

/// Whole slices that one Slices message holds: a few megabytes, at least one slice.
int slices_per_batch(const Volume& volume);

/// Slices with slices first .. first + count - 1 of the volume.
bus::Payload slices_message(const Volume& volume, std::uint32_t id, int first, int count);

/// Calls `send` with the Slices messages for one GP, each of a few megabytes of consecutive slices.
void for_each_slice_batch(const Volume& volume, std::uint32_t id, const std::vector<int>& slices,
                          const std::function<void(bus::Payload)>& send);

/// The Slices messages for GP `gp_index` of `gp_count`, likewise. Those that it owns (slice s of
/// each of its slabs) are in other messages than those that other GPs own too: traces hold a slice
/// once.
void for_each_slice_batch_of_gp(const Volume& volume, std::uint32_t id, int gp_index, int gp_count,
                                const std::function<void(bus::Payload)>& send);

/// Puts an incoming volume together. Its digest is made on the way, while more slices come.
class VolumeReceiver {
  public:
    /// Throws RequestError if the header asks for more than the limits.
    void begin(const bus::schema::VolumeHeader& header);
    /// Throws RequestError for slices outside the volume or in the wrong order.
    void add(const bus::schema::Slices& slices);
    /// The complete volume. Throws RequestError naming how many slices are missing.
    Volume finish();

  private:
    void take_report(const bus::schema::VolumeHeader& header);

    Volume volume_;
    std::size_t filled_ = 0;  ///< Slices so far.
    Digest digest_;           ///< Of their values.
};

}  // namespace pxpl5::host
