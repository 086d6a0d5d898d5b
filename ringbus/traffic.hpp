// Counts the messages that a node sends and receives.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

/// Messages of one kind that went to one node over one channel.
struct SentCount {
    NodeId to = 0;
    Body kind = Body::NONE;
    std::uint16_t channel = 0;
    std::uint64_t messages = 0, bytes = 0;  ///< Bytes of bodies.
};

/// Counts since the node began.
struct Traffic {
    std::vector<SentCount> sent;  ///< One entry per receiver, kind and channel.
    std::uint64_t received_messages = 0, received_bytes = 0;
    std::uint64_t refused_messages = 0;  ///< Dropped because they have no lawful sender (door.hpp).
};

/// Returns true for messages that only observe the machine. They are neither counted nor recorded,
/// and take no time on the modelled ring.
constexpr bool is_onlookers(Body kind) {
    return kind == Body::AskActivity || kind == Body::Activity;
}

/// Messages to one receiver, by kind and channel.
class Outgoing {
  public:
    /// Counts a message. Returns the message's number.
    std::uint64_t count(Body kind, std::uint16_t channel, std::size_t bytes) {
        if (!is_onlookers(kind)) {
            SentCount& sum = sum_of(kind, channel);
            ++sum.messages;
            sum.bytes += bytes;
        }
        return next_++;
    }
    const std::vector<SentCount>& sums() const { return sums_; }

  private:
    SentCount& sum_of(Body kind, std::uint16_t channel) {
        const auto found = std::find_if(sums_.begin(), sums_.end(), [&](const SentCount& sum) {
            return sum.kind == kind && sum.channel == channel;
        });
        return found != sums_.end() ? *found
                                    : sums_.emplace_back(SentCount{0, kind, channel, 0, 0});
    }

    std::uint64_t next_ = 0;
    std::vector<SentCount> sums_;  ///< Without the receiver `to`.
};

}  // namespace pxpl5::bus
