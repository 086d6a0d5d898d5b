// How a node reaches the others: messages out, messages in, and nothing else.
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
    /// Where others reach this node.
    virtual const std::string& endpoint() const = 0;

    /// Makes `id`, which is no peer yet, reachable. Messages sent to it before it listens are kept.
    virtual void add_peer(NodeId id, const std::string& endpoint) = 0;
    /// Drops what has not left yet. A later peer of this id counts its messages from 0 again.
    virtual void remove_peer(NodeId id) = 0;

    /// Sends, or queues while the peer has given no credit. Never blocks. `to` is a known peer.
    /// Throws NodeFault if too much waits already or the payload is too large for any receiver.
    virtual void send(NodeId to, Payload payload) = 0;

    /// Memory for builders of large bodies, from which they leave without being copied, or null for
    /// the heap. Valid as long as the link; so are the bodies.
    virtual flatbuffers::Allocator* body_allocator() { return nullptr; }

    /// Messages queued here because their receivers have given no credit. receive() takes credit
    /// and sends them.
    virtual std::size_t queued() const = 0;

    /// Counts since the beginning; of peers that were removed, not what was sent to them.
    virtual Traffic traffic() const { return {}; }

    /// The next message, if one is here. Throws BadMessage for a message that cannot be trusted and
    /// WireFault (wire.hpp) for a lost one; the link goes on with the next.
    virtual std::optional<Message> receive() = 0;

    /// Waits for input. Returns false after `timeout_ms` without any, or if a signal came first; a
    /// negative timeout never ends.
    virtual bool wait(int timeout_ms) = 0;
};

}  // namespace pxpl5::bus
