// The interface of every node: a step function from messages to messages.
#pragma once

#include <span>
#include <string>

#include "ringbus/message.hpp"
#include "ringbus/stage_clock.hpp"

namespace pxpl5::bus {

/// Takes the messages that a node sends. Messages to one destination leave in order.
class Outbox {
  public:
    virtual ~Outbox() = default;
    virtual void send(NodeId to, Payload payload) = 0;
    /// The link's Link::body_allocator().
    virtual flatbuffers::Allocator* body_allocator() { return nullptr; }
    /// The clock of the node's stages; null if the node is not timed.
    virtual StageClock* clock() { return nullptr; }

    void send(std::span<const NodeId> to, const Payload& payload) {
        for (const NodeId id : to) {
            send(id, payload);
        }
    }
};

/// The reason of a Fault for std::bad_alloc.
inline constexpr const char* memory_exhausted = "this computer's memory is exhausted";

/// Thrown by a node for a request that it cannot carry out. The driver sends it to the host as a
/// Fault, and the node continues with the next message.
struct NodeFault : std::runtime_error {
    NodeFault(schema::FaultCode fault_code, const std::string& reason, FaultCause fault_cause = {})
        : std::runtime_error(reason), code(fault_code), cause(fault_cause) {}
    schema::FaultCode code;
    FaultCause cause;  ///< The driver adds the message that the node was receiving.
};

/// State of a node for its Activity message.
struct NodeStatus {
    std::uint64_t memory_bytes = 0;  ///< All three: see Activity in schema/activity.fbs.
    std::size_t queue = 0;
    std::uint64_t frames = 0;
};

/// The current work of a node, for errors about a node that does not answer.
struct Doing {
    Body kind = Body::NONE;     ///< Kind of the message that asked for the work.
    std::uint32_t subject = 0;  ///< Surface or frame of the work.
    std::uint32_t done = 0;     ///< Finished pieces, for example slabs.
    std::uint32_t total = 0;    ///< All pieces; 0 if unknown.
};

/// Firmware. One thread drives it. It never blocks or sleeps, and no decision depends on a clock.
class Node {
  public:
    virtual ~Node() = default;

    /// Takes one message. Long work is queued here and done in work(). The first message is
    /// Topology. Throws NodeFault.
    virtual void receive(const Message& message, Outbox& out) = 0;

    /// Does one small piece (at most about 10 ms) of the queued work, the newest requests first.
    /// Returns true while work remains. The driver receives messages between two pieces.
    virtual bool work(Outbox& out) = 0;

    virtual NodeStatus status() const { return {}; }

    /// The work that work() continues, also while the node waits within it; {} if there is none.
    /// The loop asks before each piece of work and each wait, so the answer must be cheap.
    virtual Doing doing() { return {}; }
};

}  // namespace pxpl5::bus
