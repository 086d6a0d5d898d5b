// Models a message on the 1993 ring: channel, departure and arrival.
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
    std::uint64_t bytes_per_s = 80'000'000;  ///< Rate of one channel. [S]
    std::uint32_t hop_ns = 50;               ///< From one ring interface to the next. [P]
    std::uint32_t header_words = 2;          ///< Words before the body. [P]
    std::uint32_t word_bytes = 4;            ///< [D]
};

inline constexpr std::size_t max_channels = 64;

struct Stamp {
    std::uint16_t channel = 0;
    std::uint64_t departure_ns = 0;
    std::uint64_t arrival_ns = 0;
};

/// One sender's view of the ring. The model knows only this sender's messages. Each message takes
/// the channel that is free first, for its whole length. A destination takes one message at a time.
class ChannelModel {
  public:
    ChannelModel() = default;
    /// ring_order   Node ids in ring order.
    ChannelModel(const RingParameters& parameters, const std::vector<NodeId>& ring_order);

    /// Returns the time that a body of this size takes on a channel, header included.
    std::uint64_t occupancy_ns(std::uint64_t body_bytes) const;
    /// Returns the number of interfaces between two nodes along the ring.
    std::uint32_t hops(NodeId from, NodeId to) const;
    /// Places the next message of `from`. The order of the calls is the order of the messages.
    Stamp place(NodeId from, NodeId to, std::uint64_t body_bytes);
    /// Advances the modelled time. No later message departs earlier.
    void advance_to(std::uint64_t time_ns);
    std::uint64_t now_ns() const { return now_ns_; }

  private:
    RingParameters parameters_;
    std::map<NodeId, std::uint32_t> position_;
    std::array<std::uint64_t, max_channels> free_ns_{};
    std::map<NodeId, std::uint64_t> destination_free_ns_;
    std::uint64_t now_ns_ = 0;
};

}  // namespace pxpl5::bus
