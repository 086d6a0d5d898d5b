// Distributes a volume's slices to the GPs as slice sets.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
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

/// The messages of a volume, ascending, each of a few megabytes. All slices of a batch go to the
/// same GPs, so that the GPs share the message. All slices of a batch have the same owner (the GP
/// whose slabs begin with them), so that traces hold a slice once.
std::vector<SliceBatch> slice_batches(const Volume& volume, int gp_count);

/// The batches that GP `gp_index` of `gp_count` needs, ascending.
std::vector<SliceBatch> batches_for_gp(const Volume& volume, int gp_index, int gp_count);

/// Sends a volume's slices to the GPs: the slices that are there, as far as the GPs take them.
class VolumeDistribution {
  public:
    /// How to reach the GPs, by index.
    struct Outlet {
        std::function<bool(std::size_t gp)> takes_more;
        std::function<void(std::size_t gp, const bus::Payload&)> send;
        flatbuffers::Allocator* allocator = nullptr;  ///< For bodies; null for the heap.
    };

    /// volume  Only its shape is read; slices may still be missing. A volume that the GPs read
    ///         from its file has no messages but the VolumeEnd.
    VolumeDistribution(const Volume& volume, std::uint32_t id, int gp_count);

    /// Sends all messages that can go, and VolumeEnd after a GP's last slice.
    /// slices_there  Number of slices of `volume` that are there.
    void send_more(const Volume& volume, int slices_there, const Outlet& outlet);

    int sent() const { return sent_; }    ///< Messages of slices so far.
    int total() const { return total_; }  ///< Messages of slices in the end.

  private:
    struct Queue {
        std::vector<SliceBatch> batches;
        std::size_t next = 0;
        bool ended = false;
    };
    /// A packed batch, until all of its GPs have been sent it.
    struct Packed {
        bus::Payload payload;
        int receivers = 0;  ///< Still to come.
    };

    bus::Payload pack(const Volume& volume, const SliceBatch& batch,
                      flatbuffers::Allocator* allocator);

    std::uint32_t id_;
    std::vector<Queue> queues_;     ///< By GP.
    std::map<int, int> receivers_;  ///< Number of GPs that need a batch, by its first slice.
    std::map<int, Packed> packed_;  ///< By the first slice.
    int sent_ = 0, total_ = 0;
};

}  // namespace pxpl5::host
