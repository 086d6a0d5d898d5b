// Distributes a volume's slices to the GPs as slice sets.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "host/volume/volume_messages.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// Up to this size a volume is distributed as in the paper, which balances best: sets of one slab.
/// A slice then goes to up to four GPs, two of them keep it, and each holds 6 bytes of gradients
/// with every voxel: up to 16 times 32 MiB on two GPs. Larger volumes have larger sets
/// (ringbus/rules/slabs.hpp): the GP then stores s + 3 slices for a set of s slabs, without
/// gradients.
inline constexpr std::size_t max_paper_bytes = std::size_t{32} << 20;
/// Volume::slabs_per_set for a machine of `gp_count` GPs. It changes no surface and no picture.
int slabs_per_set_for(const Volume& volume, int gp_count);

/// The slices that GP `gp_index` of `gp_count` needs, ascending: slab s (between slices s and s +
/// 1) goes to GP (s / slabs_per_set) mod gp_count, with slices s-1 .. s+2 as far as they exist.
/// Source: Yoo & Chen, section IV, "Dataset-distribution"; sets of several slabs are ours.
std::vector<int> slices_for_gp(const Volume& volume, int gp_index, int gp_count);

/// Consecutive slices that travel in one message.
struct SliceBatch {
    int first = 0, count = 0;
    int end() const { return first + count; }
    friend bool operator==(const SliceBatch&, const SliceBatch&) = default;
};

/// What goes to GP `gp_index` of `gp_count`, ascending, each of a few megabytes. Slices that it
/// owns (slice s of each of its slabs) are in other messages than those that other GPs own too:
/// traces hold a slice once.
std::vector<SliceBatch> batches_for_gp(const Volume& volume, int gp_index, int gp_count);

/// Hands a volume's slices to the GPs: those that are there, as far as the GPs take them.
class VolumeDistribution {
  public:
    /// The ways to the GPs, by index.
    struct Road {
        std::function<bool(std::size_t gp)> takes_more;
        std::function<void(std::size_t gp, bus::Payload)> send;
    };

    /// volume  Its shape counts; slices may still be missing.
    VolumeDistribution(const Volume& volume, std::uint32_t id, int gp_count);

    /// Sends what can go, and VolumeEnd after a GP's last slice.
    /// slices_there  The first so many slices of `volume` are there.
    void send_more(const Volume& volume, int slices_there, const Road& road);

    int sent() const { return sent_; }    ///< Messages of slices.
    int total() const { return total_; }  ///< Likewise, in the end.

  private:
    struct Way {
        std::vector<SliceBatch> batches;
        std::size_t next = 0;
        bool ended = false;
    };
    std::uint32_t id_;
    std::vector<Way> ways_;  ///< By GP.
    int sent_ = 0, total_ = 0;
};

}  // namespace pxpl5::host
