#include "host/session/volume_transfer.hpp"

#include <algorithm>
#include <utility>

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

int owner_of(const Volume& volume, int gp_count, int slab) {
    return slab / volume.slabs_per_set % gp_count;
}

}  // namespace

int slabs_per_set_for(const Volume& volume, int gp_count) {
    const std::size_t bytes = slice_bytes(volume) * static_cast<std::size_t>(volume.nz);
    if (bytes <= max_paper_bytes) {
        return 1;
    }
    const int sets = gp_count * sets_per_gp;
    return std::clamp((volume.nz - 1 + sets - 1) / sets, 2, max_slabs_per_set);
}

std::vector<int> slices_for_gp(const Volume& volume, int gp_index, int gp_count) {
    std::vector<int> slices;
    for (int slab = 0; slab < volume.nz - 1; ++slab) {
        if (owner_of(volume, gp_count, slab) == gp_index) {
            const int first = std::max({slab - 1, 0, slices.empty() ? 0 : slices.back() + 1});
            for (int z = first; z <= std::min(slab + 2, volume.nz - 1); ++z) {
                slices.push_back(z);
            }
        }
    }
    return slices;
}

std::vector<SliceBatch> batches_for_gp(const Volume& volume, int gp_index, int gp_count) {
    const auto is_own = [&](int z) {
        return owner_of(volume, gp_count, std::max(std::min(z, volume.nz - 2), 0)) == gp_index;
    };
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
