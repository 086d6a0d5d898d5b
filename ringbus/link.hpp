// The connection of a node to the other nodes: sends and receives messages.
#pragma once

#include <optional>
#include <string>

#include "ringbus/message.hpp"
#include "ringbus/traffic.hpp"

namespace pxpl5::bus {

/// One node's connection to the ring. One thread uses it.
class Link {
  public:
    virtual ~Link() = default;

    virtual NodeId id() const = 0;
    /// The address of this node.
    virtual const std::string& endpoint() const = 0;

    /// Adds peer `id`, which must be new. Messages to it wait until it listens. The link drops
    /// messages of nodes that are no peers, and messages that the peer's role may not send to this
    /// node (law.hpp). Throws std::invalid_argument if `endpoint` is not private to this computer.
    virtual void add_peer(NodeId id, schema::Role role, const std::string& endpoint) = 0;
    /// Drops messages that have not left. A later peer of this id counts messages from 0 again.
    virtual void remove_peer(NodeId id) = 0;

    /// Sends, or queues while the peer grants no credit. Never blocks. `to` must be a peer.
    /// Throws NodeFault if the queue is full or the payload exceeds max_body_bytes.
    virtual void send(NodeId to, Payload payload) = 0;

    /// Memory for builders of large bodies, which then leave without a copy. Null means the heap.
    /// The memory and the bodies are valid as long as the link.
    virtual flatbuffers::Allocator* body_allocator() { return nullptr; }

    /// Messages that wait here for their receivers' credit. receive() takes credit and sends them.
    virtual std::size_t queued() const = 0;

    /// Counts since the start. Messages to removed peers are not included.
    virtual Traffic traffic() const { return {}; }

    /// Returns the next message, if one has arrived. Throws BadMessage for an invalid message and
    /// WireFault (wire.hpp) for a lost one. The next call continues with the next message.
    virtual std::optional<Message> receive() = 0;

    /// Waits for input. Returns false after `timeout_ms` without input, or after a signal. A
    /// negative timeout never ends.
    virtual bool wait(int timeout_ms) = 0;
};

}  // namespace pxpl5::bus
