// Drives a node over a link.
#pragma once

#include <functional>
#include <string>

#include "ringbus/link.hpp"
#include "ringbus/node.hpp"
#include "ringbus/pulse.hpp"

namespace pxpl5::bus {

/// An Outbox that sends over a link.
class LinkOutbox final : public Outbox {
  public:
    using Outbox::send;
    /// clock  The node's clock; may be null.
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

/// Returns the next message, if one has arrived. Sends a Fault to the host for each invalid
/// message.
std::optional<Message> receive_or_report(Link& link, Outbox& out);

/// Passes `message` to the node in stage::receive. Sends what the node throws to the host as a
/// Fault.
void deliver(Node& node, NodeId self, const Message& message, Outbox& out);

/// Does one piece of the node's work in stage::work, with the same faults. Returns true while work
/// remains.
bool work_once(Node& node, NodeId self, Outbox& out);

/// Delivers messages and works until Shutdown, and answers AskActivity itself. Receives all waiting
/// messages before each piece of work. Does no work while sent messages wait for credit.
///
/// alive   Called after each quiet second; false ends the loop.
/// pulse   Shows the loop's steps.
/// Returns true after Shutdown, false if `alive` returned false.
bool run_node(Node& node, Link& link, const std::function<bool()>& alive, Pulse& pulse);
inline bool run_node(Node& node, Link& link, const std::function<bool()>& alive) {
    Pulse none;
    return run_node(node, link, alive, none);
}

}  // namespace pxpl5::bus
