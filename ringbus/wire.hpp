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
        : NodeFault(fault_code, reason, {known_kind(header)}),
          source(header.source()),
          sequence(header.sequence()) {}
    NodeId source;
    std::uint64_t sequence;
};

/// Messages of one sender that a receiver may miss and go on with the next. Before the first
/// message of a sender, it may miss one.
inline constexpr std::uint64_t max_missing = 1024, max_missing_first = 1;
/// A message may arrive this much later than the receiver's modelled time: far more than a node can
/// fall behind without a message. A message of the host may arrive at any time up to the last.
inline constexpr std::uint64_t max_ahead_ns = std::uint64_t{24} * 3600 * 1'000'000'000;
inline constexpr std::uint64_t last_time_ns = std::uint64_t{1} << 62;
/// Largest logical time. Each message adds 1.
inline constexpr std::uint64_t last_clock = std::uint64_t{1} << 62;

/// Makes headers of outgoing messages and checks the numbers of incoming ones.
class Wire {
  public:
    explicit Wire(NodeId self) : self_(self) {}

    void set_model(const ChannelModel& model) { model_ = model; }

    /// Throws NodeFault for a body that exceeds max_body_bytes.
    static void check_size(NodeId to, Body kind, std::size_t body_bytes) {
        if (body_bytes > max_body_bytes) {
            throw NodeFault(schema::FaultCode::bad_input,
                            fmt::format("{} for node {} has {} bytes, a message holds {} at most",
                                        kind_name(kind), to, body_bytes, max_body_bytes));
        }
    }

    /// Throws NodeFault as check_size().
    schema::Header header_for(NodeId to, Body kind, std::size_t body_bytes) {
        check_size(to, kind, body_bytes);
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
        return expected == received_.end() || header.sequence() >= expected->second.next;
    }

    /// Whether the receiver's times follow those of a message. Times of an io process do not count:
    /// what a damaged file makes it send must not move the host's.
    enum class Times : std::uint8_t { followed, ignored };

    /// Throws WireFault if messages from this sender are missing or repeated, if the message is for
    /// another node, or if its times are too far ahead. A number or a time that no sound sender
    /// can have reached is not adopted.
    void accept(const schema::Header& header, Times times = Times::followed) {
        if (!is_ours(header)) {
            return;
        }
        if (header.destination() != self_) {
            throw WireFault(header, schema::FaultCode::bad_message,
                            fmt::format("message from node {} for node {} came to node {}",
                                        header.source(), header.destination(), self_));
        }
        take_number(header);
        check_times(header);
        if (!is_onlookers(static_cast<Body>(header.kind()))) {
            ++received_messages_;
            received_bytes_ += header.body_bytes();
        }
        if (times == Times::followed) {
            clock_ = std::max(clock_, header.clock());
            model_.advance_to(header.arrival_ns());
        }
        ++clock_;
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
    /// Numbers of one sender.
    struct Expected {
        std::uint64_t next = 0;
        /// The number after a refused message. If it comes next, messages before were lost. A
        /// single wrong number thus changes nothing. 0: none.
        std::uint64_t after_gap = 0;
    };

    void take_number(const schema::Header& header) {
        const std::uint64_t number = header.sequence();
        Expected& expected = received_[header.source()];
        if (number == expected.next || (expected.after_gap != 0 && number == expected.after_gap)) {
            expected = {number + 1, 0};
            return;
        }
        const std::uint64_t most = expected.next == 0 ? max_missing_first : max_missing;
        if (number > expected.next && number - expected.next <= most) {
            expected.after_gap = number + 1;
        }
        throw WireFault(header, schema::FaultCode::lost_message,
                        fmt::format("message {} from node {} came where {} was due", number,
                                    header.source(), expected.next));
    }

    void check_times(const schema::Header& header) const {
        const std::uint64_t latest_ns =
            header.source() == host_id ? last_time_ns : model_.now_ns() + max_ahead_ns;
        if (header.arrival_ns() > latest_ns || header.clock() > last_clock) {
            throw WireFault(header, schema::FaultCode::bad_message,
                            fmt::format("message {} from node {} arrives at {} ns, clock {}; "
                                        "allowed are at most {} ns, clock {}",
                                        header.sequence(), header.source(), header.arrival_ns(),
                                        header.clock(), latest_ns, last_clock));
        }
    }

    NodeId self_;
    std::uint64_t clock_ = 0;  ///< Lamport clock: later than every message that this node has seen.
    ChannelModel model_{RingParameters{}, {}};
    std::map<NodeId, Outgoing> sent_;
    std::map<NodeId, Expected> received_;
    std::uint64_t received_messages_ = 0, received_bytes_ = 0;
};

}  // namespace pxpl5::bus
