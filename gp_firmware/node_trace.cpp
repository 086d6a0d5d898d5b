#include "gp_firmware/node_trace.hpp"

#include <algorithm>

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
    } else if (const auto* header = message.as<schema::VolumeHeader>()) {
        shape_.nz = static_cast<int>(header->nz());
        shape_.slabs_per_set = header->slabs_per_set();
    } else if (const auto* slices = message.as<schema::Slices>()) {
        const int first = static_cast<int>(slices->first_slice());
        const int end = std::min(first + static_cast<int>(slices->slice_count()), shape_.nz);
        bool has_own = first >= end || share_.gp_count == 0;  // Not as agreed: a trace shows it.
        for (int z = first; z < end && !has_own; ++z) {
            has_own =
                owner_of(shape_, share_.gp_count, slab_that_records(shape_, z)) == share_.gp_index;
        }
        return !has_own;
    }
    return false;
}

}  // namespace pxpl5::gp
