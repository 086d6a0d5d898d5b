#include "ringbus/channel_model.hpp"

#include <algorithm>
#include <cassert>

namespace pxpl5::bus {

namespace {
constexpr std::uint64_t ns_per_s = 1'000'000'000;
}

ChannelModel::ChannelModel(const RingParameters& parameters, const std::vector<NodeId>& ring_order)
    : parameters_(parameters) {
    assert(parameters.channels >= 1);
    assert(parameters.channels <= max_channels);
    assert(parameters.bytes_per_s > 0);
    for (const NodeId id : ring_order) {
        position_.emplace(id, static_cast<std::uint32_t>(position_.size()));
    }
}

std::uint64_t ChannelModel::occupancy_ns(std::uint64_t body_bytes) const {
    const std::uint64_t word = parameters_.word_bytes;
    const std::uint64_t words = parameters_.header_words + (body_bytes + word - 1) / word;
    return (words * word * ns_per_s + parameters_.bytes_per_s - 1) / parameters_.bytes_per_s;
}

std::uint32_t ChannelModel::hops(NodeId from, NodeId to) const {
    const auto a = position_.find(from), b = position_.find(to);
    if (a == position_.end() || b == position_.end()) {
        return 1;  // A node outside of the modelled ring, for example the io process.
    }
    const auto size = static_cast<std::uint32_t>(position_.size());
    return (b->second + size - a->second) % size;
}

Stamp ChannelModel::place(NodeId from, NodeId to, std::uint64_t body_bytes) {
    const auto first = free_ns_.begin();
    const auto channel = std::min_element(first, first + parameters_.channels);
    std::uint64_t& destination_free = destination_free_ns_[to];
    const std::uint64_t length = occupancy_ns(body_bytes);
    const std::uint64_t travel = std::uint64_t{hops(from, to)} * parameters_.hop_ns;

    Stamp stamp;
    stamp.channel = static_cast<std::uint16_t>(channel - first);
    // The first word must not arrive before the destination has taken the earlier message.
    const std::uint64_t accepted =
        destination_free > travel ? destination_free - travel : std::uint64_t{0};
    stamp.departure_ns = std::max({now_ns_, *channel, accepted});
    stamp.arrival_ns = stamp.departure_ns + travel + length;
    *channel = stamp.departure_ns + length;
    destination_free = stamp.arrival_ns;
    return stamp;
}

void ChannelModel::advance_to(std::uint64_t time_ns) {
    now_ns_ = std::max(now_ns_, time_ns);
}

}  // namespace pxpl5::bus
