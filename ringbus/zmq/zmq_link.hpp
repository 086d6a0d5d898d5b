// The ring between processes: one hop over ZeroMQ, one inbound socket per node, two of the host.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "ringbus/channel_model.hpp"
#include "ringbus/door.hpp"
#include "ringbus/link.hpp"
#include "ringbus/zmq/arena_layout.hpp"
#include "ringbus/zmq/credentials.hpp"

namespace pxpl5::bus {

/// Time for sent messages to leave when a socket is closed. Not 0: ZeroMQ aborts if it then loses
/// the connection between two parts of a message (libzmq issue 3442).
inline constexpr int closing_ms = 100;

/// A node's own place in the machine.
struct Self {
    NodeId id = host_id;
    schema::Role role = schema::Role::host;
};

class ZmqLink final : public Link {
  public:
    /// Binds the inbound socket of a node.
    ///
    /// bind     "ipc:///path/name" or "tcp://127.0.0.1:*"; with credentials for a network also
    ///          other addresses of this computer.
    /// credentials     Their secret is required in each Hello; their keys protect tcp.
    /// lendable_bytes  See Arena.
    /// Throws   std::invalid_argument for any other address, and for tcp without keys unless the
    ///          credentials allow it; std::runtime_error if the address cannot be bound.
    ZmqLink(const Self& self, const std::string& bind, const Credentials& credentials = {},
            std::size_t lendable_bytes = arena_bytes);
    ~ZmqLink() override;
    ZmqLink(const ZmqLink&) = delete;
    ZmqLink& operator=(const ZmqLink&) = delete;

    /// Also listens at `bind`, an ipc address for nodes on the same computer. Call before the first
    /// message. Throws as the constructor does.
    void listen_near(const std::string& bind);

    /// Binds a second inbound socket: only for nodes of `role`, which may not use the first one.
    /// Call before the first message and before poll_fd(). Throws as the constructor does.
    /// Returns its address.
    std::string listen_apart(schema::Role role, const std::string& bind);

    NodeId id() const override;
    const std::string& endpoint() const override;
    void add_peer(NodeId id, schema::Role role, const std::string& endpoint) override;
    /// Whether bodies to other computers are compressed. They arrive as they were sent, and counts
    /// and modelled times are those of the bodies themselves.
    void compress_far(bool compress);
    bool compresses_far() const;
    /// Lets the Hello of a started process in (Door::expect). add_peer() follows.
    void expect(NodeId id, schema::Role role);
    /// See Door::on_refusal().
    void on_refusal(std::function<void(const Refusal&)> report);
    /// Takes back the bodies lent to `id`, whose process has ended.
    void remove_peer(NodeId id) override;
    void send(NodeId to, Payload payload) override;
    /// Nodes on this computer read these bodies in place (arena.hpp).
    flatbuffers::Allocator* body_allocator() override;
    std::optional<Message> receive() override;
    bool wait(int timeout_ms) override;
    /// True if the last receive() stopped among refused messages, so that a flood of them keeps
    /// no caller. Call it again before waiting for poll_fd().
    bool has_more() const;
    /// Makes has_more() true until the next receive().
    void come_again();

    /// Sets the time for messages to `peer` to leave when the link is destroyed. Default:
    /// closing_ms.
    void linger(NodeId peer, int patience_ms);

    /// Becomes readable when input may have arrived. Edge-triggered: call receive() until it
    /// returns nothing, then wait.
    int poll_fd() const;
    std::size_t queued() const override;
    Traffic traffic() const override;
    /// Returns true if nothing is queued for `peer`.
    bool takes_more(NodeId peer) const;
    /// Sets ring order and parameters for the stamps of messages.
    void set_model(const ChannelModel& model);

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::bus
