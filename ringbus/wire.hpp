// Numbers and stamps outgoing messages and detects lost ones, for both links.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "ringbus/channel_model.hpp"
#include "ringbus/node.hpp"
#include "ringbus/traffic.hpp"

namespace pxpl5::bus {

/// Thrown for a message out of sequence, or at the wrong node.
struct WireFault : NodeFault {
    WireFault(const schema::Header& header, schema::FaultCode fault_code, const std::string& reason)
        : NodeFault(fault_code, reason), source(header.source()), sequence(header.sequence()) {}
    NodeId source;
    std::uint64_t sequence;
};

/// Makes headers of outgoing messages and checks the numbers of incoming ones.
class Wire {
  public:
    explicit Wire(NodeId self) : self_(self) {}

    void set_model(const ChannelModel& model) { model_ = model; }

    /// Throws NodeFault for a body that exceeds max_body_bytes.
    schema::Header header_for(NodeId to, Body kind, std::size_t body_bytes) {
        if (body_bytes > max_body_bytes) {
            throw NodeFault(schema::FaultCode::bad_input,
                            fmt::format("{} for node {} has {} bytes, a message holds {} at most",
                                        kind_name(kind), to, body_bytes, max_body_bytes));
        }
        const Stamp stamp = is_onlookers(kind) ? Stamp() : model_.place(self_, to, body_bytes);
        return {header_magic,
                protocol_version,
                static_cast<std::uint16_t>(kind),
                self_,
                to,
                stamp.channel,
                0,
                sent_[to].count(kind, stamp.channel, body_bytes),
                body_bytes,
                stamp.departure_ns,
                stamp.arrival_ns,
                ++clock_};
    }

    /// Returns true if magic and version match. Otherwise Message's constructor names the reason.
    static bool is_ours(const schema::Header& header) {
        return header.magic() == header_magic && header.version() == protocol_version;
    }

    /// Returns true if the sender has not used the number before. Requires is_ours().
    bool is_new(const schema::Header& header) const {
        const auto expected = received_.find(header.source());
        return expected == received_.end() || header.sequence() >= expected->second;
    }

    /// Throws WireFault if messages from this sender are missing or repeated, or if the message is
    /// for another node.
    void accept(const schema::Header& header) {
        if (!is_ours(header)) {
            return;
        }
        if (header.destination() != self_) {
            throw WireFault(header, schema::FaultCode::bad_message,
                            fmt::format("message from node {} for node {} came to node {}",
                                        header.source(), header.destination(), self_));
        }
        std::uint64_t& expected = received_[header.source()];
        const std::uint64_t wanted = expected;
        expected = header.sequence() + 1;
        if (header.sequence() != wanted) {
            throw WireFault(header, schema::FaultCode::lost_message,
                            fmt::format("message {} from node {} came where {} was due",
                                        header.sequence(), header.source(), wanted));
        }
        if (!is_onlookers(static_cast<Body>(header.kind()))) {
            ++received_messages_;
            received_bytes_ += header.body_bytes();
        }
        clock_ = std::max(clock_, header.clock()) + 1;
        model_.advance_to(header.arrival_ns());
    }

    /// Resets the numbers of `peer`, because a new node will use this id.
    void forget(NodeId peer) {
        sent_.erase(peer);
        received_.erase(peer);
    }

    Traffic traffic() const {
        Traffic traffic{{}, received_messages_, received_bytes_};
        for (const auto& [to, outgoing] : sent_) {
            for (SentCount sum : outgoing.sums()) {
                sum.to = to;
                traffic.sent.push_back(sum);
            }
        }
        return traffic;
    }

  private:
    NodeId self_;
    std::uint64_t clock_ = 0;  ///< Lamport clock: later than every message that this node has seen.
    ChannelModel model_{RingParameters{}, {}};
    std::map<NodeId, Outgoing> sent_;
    std::map<NodeId, std::uint64_t> received_;  ///< Number of the next message.
    std::uint64_t received_messages_ = 0, received_bytes_ = 0;
};

}  // namespace pxpl5::bus
