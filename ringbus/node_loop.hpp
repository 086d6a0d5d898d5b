// Drives a node over a link.
#pragma once

#include <functional>
#include <string>

#include "ringbus/link.hpp"
#include "ringbus/node.hpp"

namespace pxpl5::bus {

/// An Outbox that sends over a link.
class LinkOutbox final : public Outbox {
  public:
    using Outbox::send;
    /// clock  Of the node; may be null.
    explicit LinkOutbox(Link& link, StageClock* clock = nullptr) : link_(link), clock_(clock) {}
    void send(NodeId to, Payload payload) override {
        const StageClock::In sending(clock_, stage::send);
        link_.send(to, std::move(payload));
    }
    flatbuffers::Allocator* body_allocator() override { return link_.body_allocator(); }
    StageClock* clock() override { return clock_; }

  private:
    Link& link_;
    StageClock* clock_;
};

/// The Fault that `node` reports about message number `sequence` of `source`.
Payload fault_message(NodeId node, NodeId source, std::uint64_t sequence, schema::FaultCode code,
                      const std::string& reason, FaultCause cause = {});

/// The next message, if one is here; those that cannot be trusted become Faults to the host.
std::optional<Message> receive_or_report(Link& link, Outbox& out);

/// Hands `message` to the node in stage::receive; what it throws goes to the host as a Fault.
void deliver(Node& node, NodeId self, const Message& message, Outbox& out);

/// One piece of the node's work, likewise in stage::work. Returns true while there is more.
bool work_once(Node& node, NodeId self, Outbox& out);

/// Delivers and works until Shutdown has come, and answers AskActivity by itself. Reads all waiting
/// messages before each piece of work, and does none while messages are queued for want of credit.
///
/// alive   Asked after each quiet second; false ends the loop.
/// Returns true after Shutdown, false if no longer alive.
bool run_node(Node& node, Link& link, const std::function<bool()>& alive);

}  // namespace pxpl5::bus
