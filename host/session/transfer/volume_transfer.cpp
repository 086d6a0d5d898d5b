#include "host/session/transfer/volume_transfer.hpp"

#include <algorithm>
#include <utility>

#include "ringbus/rules/slabs.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

SlabSets slab_sets(const Volume& volume, int gp_count) {
    return {volume.nz, volume.slabs_per_set, gp_count};
}

/// The GP that records slice z, then the GPs that need the slice.
std::vector<int> route_of(const SlabSets& sets, int z) {
    std::vector<int> route = {sets.recorder(z)};
    for (int gp = 0; gp < sets.gp_count; ++gp) {
        if (sets.needs(gp, z)) {
            route.push_back(gp);
        }
    }
    return route;
}

}  // namespace

int slabs_per_set_for(const Volume& volume, int gp_count) {
    const std::size_t bytes = slice_bytes(volume) * static_cast<std::size_t>(volume.nz);
    if (bytes <= max_paper_bytes) {
        return 1;
    }
    return slabs_per_large_set(volume.nz - 1, gp_count);
}

std::vector<int> slices_for_gp(const Volume& volume, int gp_index, int gp_count) {
    return slab_sets(volume, gp_count).slices_needed(gp_index);
}

std::vector<SliceBatch> slice_batches(const Volume& volume, int gp_count) {
    const SlabSets sets = slab_sets(volume, gp_count);
    const int most = slices_per_batch(volume);
    std::vector<SliceBatch> batches;
    std::vector<int> last_route;
    for (int z = 0; z < volume.nz; ++z) {
        std::vector<int> route = route_of(sets, z);
        if (!batches.empty() && batches.back().count < most && route == last_route) {
            ++batches.back().count;
        } else {
            batches.push_back({z, 1});
            last_route = std::move(route);
        }
    }
    return batches;
}

std::vector<SliceBatch> batches_for_gp(const Volume& volume, int gp_index, int gp_count) {
    const SlabSets sets = slab_sets(volume, gp_count);
    std::vector<SliceBatch> batches = slice_batches(volume, gp_count);
    std::erase_if(batches,
                  [&](const SliceBatch& batch) { return !sets.needs(gp_index, batch.first); });
    return batches;
}

VolumeDistribution::VolumeDistribution(const Volume& volume, std::uint32_t id, int gp_count)
    : id_(id) {
    for (int gp = 0; gp < gp_count; ++gp) {
        queues_.push_back({volume.stored ? std::vector<SliceBatch>()  // The GPs read them.
                                         : batches_for_gp(volume, gp, gp_count)});
        total_ += static_cast<int>(queues_.back().batches.size());
        for (const SliceBatch& batch : queues_.back().batches) {
            ++receivers_[batch.first];
        }
    }
}

/// Packs a batch, or takes the message that was packed for another GP.
bus::Payload VolumeDistribution::pack(const Volume& volume, const SliceBatch& batch,
                                      flatbuffers::Allocator* allocator) {
    const auto found = packed_.find(batch.first);
    if (found == packed_.end()) {
        Packed packed{slices_message(volume, id_, batch.first, batch.count, allocator),
                      receivers_.at(batch.first) - 1};
        const bus::Payload payload = packed.payload;
        if (packed.receivers > 0) {
            packed_.emplace(batch.first, std::move(packed));
        }
        return payload;
    }
    bus::Payload payload = found->second.payload;
    if (--found->second.receivers == 0) {
        packed_.erase(found);
    }
    return payload;
}

void VolumeDistribution::send_more(const Volume& volume, int slices_there, const Outlet& outlet) {
    for (std::size_t gp = 0; gp < queues_.size(); ++gp) {
        Queue& queue = queues_[gp];
        while (queue.next < queue.batches.size() && outlet.takes_more(gp) &&
               queue.batches[queue.next].end() <= slices_there) {
            outlet.send(gp, pack(volume, queue.batches[queue.next++], outlet.allocator));
            ++sent_;
        }
        if (queue.next == queue.batches.size() && !queue.ended) {
            queue.ended = true;
            outlet.send(gp, bus::pack(schema::VolumeEndT{{}, id_, volume.digest}));
        }
    }
}

}  // namespace pxpl5::host
