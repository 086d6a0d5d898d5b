#include "gp_firmware/node/copied_slices.hpp"

#include <algorithm>

#include "ringbus/trace/recorder.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;

Share share_of(const schema::Topology& topology, bus::NodeId self) {
    Share share{0, 0};
    for (const auto* node : *topology.nodes()) {
        if (node->role() == schema::Role::gp) {
            ++share.gp_count;
            share.gp_index = node->id() == self ? node->index() : share.gp_index;
        }
    }
    return share;
}

}  // namespace

bool CopiedSlices::operator()(const bus::Message& message) {
    if (const auto* topology = message.as<schema::Topology>()) {
        share_ = share_of(*topology, message.header().destination());
        flight_ = topology->recording() == Recording::flight;
    } else if (const auto* header = message.as<schema::VolumeHeader>()) {
        shape_.nz = static_cast<int>(header->nz());
        shape_.slabs_per_set = header->slabs_per_set();
        shape_.nx = static_cast<int>(header->nx());
        shape_.ny = static_cast<int>(header->ny());
        shape_.type = header->type();
        too_large_ = flight_ && own_bytes() > bus::trace::Limits{}.setup_bytes;
    } else if (const auto* slices = message.as<schema::Slices>()) {
        const int first = static_cast<int>(slices->first_slice());
        const int end = std::min(first + static_cast<int>(slices->slice_count()), shape_.nz);
        bool has_own = first >= end || share_.gp_count == 0;  // Records unexpected messages.
        for (int z = first; z < end && !has_own; ++z) {
            has_own = slab_sets(shape_, share_.gp_count).recorder(z) == share_.gp_index;
        }
        return !has_own || (too_large_ && first < end);
    }
    return false;
}

std::size_t CopiedSlices::own_bytes() const {
    std::size_t bytes = 0;
    for (int z = 0; share_.gp_count > 0 && z < shape_.nz; ++z) {
        const int owner = slab_sets(shape_, share_.gp_count).recorder(z);
        bytes += owner == share_.gp_index ? shape_.slice_voxels() * size_bytes(shape_.type) : 0;
    }
    return bytes;
}

}  // namespace pxpl5::gp
