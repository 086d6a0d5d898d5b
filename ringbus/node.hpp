// What every node of the machine is: a step function from messages to messages.
#pragma once

#include <span>
#include <string>

#include "ringbus/message.hpp"
#include "ringbus/stage_clock.hpp"

namespace pxpl5::bus {

/// Where a node puts the messages that it sends. They leave in this order, per destination.
class Outbox {
  public:
    virtual ~Outbox() = default;
    virtual void send(NodeId to, Payload payload) = 0;
    /// Link::body_allocator() of the link behind it.
    virtual flatbuffers::Allocator* body_allocator() { return nullptr; }
    /// Where the node says which stage of its work goes on; null if nobody times it.
    virtual StageClock* clock() { return nullptr; }

    void send(std::span<const NodeId> to, const Payload& payload) {
        for (const NodeId id : to) {
            send(id, payload);
        }
    }
};

/// The reason of a Fault for std::bad_alloc.
inline constexpr const char* memory_exhausted = "this computer's memory is exhausted";

/// Thrown by a node for input that it cannot obey: the driver sends it to the host as Fault and the
/// node goes on with the next message.
struct NodeFault : std::runtime_error {
    NodeFault(schema::FaultCode fault_code, const std::string& reason, FaultCause fault_cause = {})
        : std::runtime_error(reason), code(fault_code), cause(fault_cause) {}
    schema::FaultCode code;
    FaultCause cause;  ///< The driver adds the message that the node was receiving.
};

/// What a node tells of itself when it is asked.
struct NodeStatus {
    std::uint64_t memory_bytes = 0;  ///< As of schema Activity, like the others.
    std::size_t queue = 0;
    std::uint64_t frames = 0;
};

/// Firmware. One thread drives it; it never blocks, sleeps or reads a clock to decide something.
class Node {
  public:
    virtual ~Node() = default;

    /// Takes one message. Long work is only noted here and done in work().
    /// Called with Topology before anything else. Throws NodeFault.
    virtual void receive(const Message& message, Outbox& out) = 0;

    /// Does one small piece (at most about 10 ms) of the noted work, newest wishes first.
    /// Returns true while there is more; the driver looks for new messages between pieces.
    virtual bool work(Outbox& out) = 0;

    virtual NodeStatus status() const { return {}; }
};

}  // namespace pxpl5::bus
