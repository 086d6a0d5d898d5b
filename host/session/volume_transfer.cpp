#include "host/session/volume_transfer.hpp"

#include <utility>

#include "ringbus/rules/slabs.hpp"

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

SlabSets slab_sets(const Volume& volume, int gp_count) {
    return {volume.nz, volume.slabs_per_set, gp_count};
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

std::vector<SliceBatch> batches_for_gp(const Volume& volume, int gp_index, int gp_count) {
    const auto is_own = [&](int z) { return slab_sets(volume, gp_count).recorder(z) == gp_index; };
    const int most = slices_per_batch(volume);
    std::vector<SliceBatch> batches;
    for (const int z : slices_for_gp(volume, gp_index, gp_count)) {
        SliceBatch* last = batches.empty() ? nullptr : &batches.back();
        if (last != nullptr && z == last->end() && last->count < most &&
            is_own(z) == is_own(last->first)) {
            ++last->count;
        } else {
            batches.push_back({z, 1});
        }
    }
    return batches;
}

VolumeDistribution::VolumeDistribution(const Volume& volume, std::uint32_t id, int gp_count)
    : id_(id) {
    for (int gp = 0; gp < gp_count; ++gp) {
        ways_.push_back({batches_for_gp(volume, gp, gp_count), 0});
        total_ += static_cast<int>(ways_.back().batches.size());
    }
}

void VolumeDistribution::send_more(const Volume& volume, int slices_there, const Road& road) {
    for (std::size_t gp = 0; gp < ways_.size(); ++gp) {
        Way& way = ways_[gp];
        while (way.next < way.batches.size() && road.takes_more(gp) &&
               way.batches[way.next].end() <= slices_there) {
            const SliceBatch& batch = way.batches[way.next++];
            road.send(gp, slices_message(volume, id_, batch.first, batch.count));
            ++sent_;
        }
        if (way.next == way.batches.size() && !way.ended) {
            way.ended = true;
            road.send(gp, bus::pack(schema::VolumeEndT{{}, id_}));
        }
    }
}

}  // namespace pxpl5::host
