// The ring between processes: one hop over ZeroMQ, one inbound socket per node.
#pragma once

#include <memory>
#include <string>

#include "ringbus/arena_layout.hpp"
#include "ringbus/channel_model.hpp"
#include "ringbus/link.hpp"

namespace pxpl5::bus {

/// What was sent may take so long to leave when a socket is closed. Not 0: ZeroMQ aborts if it then
/// loses the connection between two parts of a message (libzmq issue 3442).
inline constexpr int closing_ms = 100;

class ZmqLink final : public Link {
  public:
    /// Binds the inbound socket of node `id`.
    ///
    /// bind     "ipc:///path/name" or "tcp://127.0.0.1:*"; nothing here is encrypted.
    /// lendable_bytes  Of its Arena.
    /// Throws   std::invalid_argument for any other address, std::runtime_error if it cannot be
    ///          bound.
    ZmqLink(NodeId id, const std::string& bind, std::size_t lendable_bytes = arena_bytes);
    ~ZmqLink() override;
    ZmqLink(const ZmqLink&) = delete;
    ZmqLink& operator=(const ZmqLink&) = delete;

    NodeId id() const override;
    const std::string& endpoint() const override;
    void add_peer(NodeId id, const std::string& endpoint) override;
    /// The process behind `id` has ended: what it was lent comes back.
    void remove_peer(NodeId id) override;
    void send(NodeId to, Payload payload) override;
    /// Bodies from here are read where they lie by nodes of this computer (arena.hpp).
    flatbuffers::Allocator* body_allocator() override;
    std::optional<Message> receive() override;
    bool wait(int timeout_ms) override;

    /// What was sent to `peer` may take so long to leave when the link is destroyed; without this,
    /// closing_ms.
    void linger(NodeId peer, int patience_ms);

    /// Becomes readable when input may have come. Edge-triggered: call receive() until it has none
    /// before waiting.
    int poll_fd() const;
    std::size_t queued() const override;
    Traffic traffic() const override;
    /// Whether nothing is queued for `peer`.
    bool takes_more(NodeId peer) const;
    /// Ring order and parameters for the stamps on messages.
    void set_model(const ChannelModel& model);

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::bus
