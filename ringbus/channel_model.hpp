// What a message would have cost on the machine's ring: channel, departure, arrival.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Parameters of the ring, with their provenance: [S] the source paper, [D] derived, [P] proposed
/// here, because no public text has them.
struct RingParameters {
    std::uint32_t channels = 8;              ///< [S]
    std::uint64_t bytes_per_s = 80'000'000;  ///< Of one channel. [S]
    std::uint32_t hop_ns = 50;               ///< From one ring interface to the next. [P]
    std::uint32_t header_words = 2;          ///< Sent before the body's words. [P]
    std::uint32_t word_bytes = 4;            ///< [D]
};

inline constexpr std::size_t max_channels = 64;

struct Stamp {
    std::uint16_t channel = 0;
    std::uint64_t departure_ns = 0;
    std::uint64_t arrival_ns = 0;
};

/// One sender's view of the ring. It knows its own messages only: each takes the channel that is
/// free first and holds it for its whole length; the destination takes one message at a time.
class ChannelModel {
  public:
    ChannelModel() = default;
    /// ring_order   Node ids in the order in which the ring passes them.
    ChannelModel(const RingParameters& parameters, const std::vector<NodeId>& ring_order);

    /// Time on a channel for a body of that size, header included.
    std::uint64_t occupancy_ns(std::uint64_t body_bytes) const;
    /// Interfaces between two nodes along the ring's one direction.
    std::uint32_t hops(NodeId from, NodeId to) const;
    /// Places the next message of `from`. Messages are placed in the order of the calls.
    Stamp place(NodeId from, NodeId to, std::uint64_t body_bytes);
    /// The node has learned of this modelled time: nothing leaves earlier.
    void advance_to(std::uint64_t time_ns);

  private:
    RingParameters parameters_;
    std::map<NodeId, std::uint32_t> position_;
    std::array<std::uint64_t, max_channels> free_ns_{};
    std::map<NodeId, std::uint64_t> destination_free_ns_;
    std::uint64_t now_ns_ = 0;
};

}  // namespace pxpl5::bus
