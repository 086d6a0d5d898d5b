#include "ringbus/zmq/zmq_link.hpp"

#include <fmt/core.h>

#include <cassert>
#include <cstring>
#include <deque>
#include <map>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>
#include <zmq.hpp>

#include "ringbus/credit.hpp"
#include "ringbus/wire.hpp"
#include "ringbus/zmq/arena.hpp"
#include "ringbus/zmq/gate.hpp"
#include "ringbus/zmq/guard.hpp"
#include "ringbus/zmq/inbound.hpp"
#include "ringbus/zmq/packed_body.hpp"
#include "ringbus/zmq/zmq_parts.hpp"

namespace pxpl5::bus {

namespace {

/// Refused messages, and credit, that receive() takes in one call.
constexpr int max_unreturned = 1024;

/// A sender that does not keep to its window waits. No sender blocks: each stores what waits.
void prepare_inbound(zmq::socket_t& socket) {
    prepare(socket);
    socket.set(zmq::sockopt::rcvhwm, static_cast<int>(max_unread_messages));
}

struct Peer {
    std::string endpoint;
    zmq::socket_t socket;  ///< Opened by the first message: most peers never get one.
    int linger_ms = closing_ms;
    bool shares_memory = false;  ///< May open this node's arena, and offer its own.
    bool has_offer = false;
    bool is_far = false;  ///< On another computer.
    Window window;
    std::deque<Payload> waiting;  ///< Waits for credit.
    std::uint64_t waiting_bytes = 0;
    Consumed consumed;  ///< Consumed messages of the peer without a credit yet.

    bool is_full() const {
        return waiting.size() >= max_waiting_messages || waiting_bytes >= max_waiting_bytes;
    }
};

}  // namespace

struct ZmqLink::Parts {
    Parts(const Self& own, const Credentials& own_credentials, std::size_t lendable_bytes)
        : self(own),
          credentials(own_credentials),
          arena(lendable_bytes),
          gate(own.role, own_credentials.secret) {}

    Self self;
    Credentials credentials;
    Arena arena;  ///< Destroyed after the context, whose thread may send bodies from it.
    Guard guard;  ///< Outlives the context, which ends its thread.
    zmq::context_t context = make_context();
    Inbound inbound{context};
    std::string endpoint;
    std::map<NodeId, Peer> peers;
    std::map<NodeId, std::shared_ptr<ArenaView>> views;  ///< Arenas that peers have offered.
    std::size_t queued = 0;                              ///< Waiting messages of all peers.
    bool has_more = false;
    bool compresses_far = false;
    Packer packer;
    Gate gate;
    Wire wire{self.id};

    void transmit(NodeId to, Peer& peer, const Payload& payload) {
        connect(peer);
        const schema::Header header = wire.header_for(to, payload.kind(), payload.bytes().size());
        if (const auto place = arena.lend(to, payload)) {
            send_part(peer, part_of(header, *place), zmq::send_flags::none);
            return;
        }
        if (peer.is_far && compresses_far && payload.bytes().size() >= min_packed_body_bytes) {
            if (auto packed = packer.pack(payload.bytes())) {
                send_part(peer, part_of(header, PackedBody()), zmq::send_flags::sndmore);
                send_part(peer, std::move(*packed), zmq::send_flags::none);
                return;
            }
        }
        const bool offers = peer.shares_memory && !peer.has_offer && arena.can_lend(payload);
        peer.has_offer = peer.has_offer || offers;
        send_part(peer,
                  offers ? part_of(header, arena.offer()) : zmq::message_t(&header, sizeof header),
                  zmq::send_flags::sndmore);
        send_part(peer, part_of(payload), zmq::send_flags::none);
    }

    /// Begin or end of new content: memory of what was sent before is not needed soon. At the end,
    /// receivers have returned more of it.
    void note_content(Body kind) {
        if (kind == Body::VolumeHeader || kind == Body::SceneBegin || kind == Body::VolumeReady) {
            arena.return_memory();
        }
    }

    void connect(Peer& peer) {
        if (peer.socket.handle() == nullptr) {
            peer.socket = zmq::socket_t(context, zmq::socket_type::push);
            prepare(peer.socket);
            peer.socket.set(zmq::sockopt::linger, peer.linger_ms);
            if (credentials.keys) {
                guard_outbound(peer.socket, *credentials.keys);
            }
            uninterrupted([&] { peer.socket.connect(peer.endpoint); });
        }
    }

    static void send_part(Peer& peer, zmq::message_t part, zmq::send_flags flags) {
        uninterrupted([&] { return peer.socket.send(part, flags); });
    }

    void flush(NodeId to, Peer& peer) {
        while (!peer.waiting.empty() && peer.window.has_room(peer.waiting.front().bytes().size(),
                                                             peer.waiting.front().kind())) {
            const Payload payload = std::move(peer.waiting.front());
            peer.waiting.pop_front();
            peer.waiting_bytes -= payload.bytes().size();
            --queued;
            peer.window.take(payload.bytes().size());
            transmit(to, peer, payload);
        }
    }

    /// Verifies the message and its sequence number.
    Message read(const Arrived& arrived) {
        const schema::Header& header = arrived.header;
        const auto found = arrived.place ? views.find(header.source()) : views.end();
        const bool is_known = found != views.end();
        // An invalid new message must release its memory. A repeated message owns none: its ticket
        // may already belong to a message in transit.
        auto owner =
            is_known && wire.is_new(header) ? found->second->hold(arrived.place->ticket) : nullptr;
        wire.accept(header, arrived.entrance == Entrance::apart ? Wire::Times::ignored
                                                                : Wire::Times::followed);
        if (arrived.place && !is_known) {
            throw BadMessage(header, fmt::format("message from node {}: its body is at {} of an "
                                                 "arena that was never offered",
                                                 header.source(), arrived.place->offset));
        }
        if (arrived.place) {
            const auto body = found->second->body(header, *arrived.place);
            if (!owner) {
                throw BadMessage(header, fmt::format("message from node {}: ticket {} is not lent",
                                                     header.source(), arrived.place->ticket));
            }
            return {header, body, std::move(owner)};
        }
        if (arrived.offer) {
            open_arena(header.source(), *arrived.offer);
        }
        if (arrived.packed && !is_far(header.source())) {
            throw BadMessage(header, fmt::format("message from node {}: a compressed body from "
                                                 "this computer",
                                                 header.source()));
        }
        if (arrived.packed) {
            return message_of(header, unpacked_body(header, *arrived.packed, *arrived.body));
        }
        return message_of(header, arrived.body);
    }

    bool is_far(NodeId source) const {
        const auto peer = peers.find(source);
        return peer != peers.end() && peer->second.is_far;
    }

    /// Maps the arena of a peer that may share memory. Other bodies are copied.
    void open_arena(NodeId source, const ArenaOffer& offer) {
        const auto peer = peers.find(source);
        if (peer != peers.end() && peer->second.shares_memory) {
            if (auto view = ArenaView::open(offer, self.id)) {
                views.insert_or_assign(source, std::move(view));
            }
        }
    }

    /// Counts the received bytes, valid or not. Otherwise the sender's window would shrink forever.
    /// A node that is not yet a peer gets no credit.
    void count_consumed(const Arrived& arrived) {
        const schema::Header& header = arrived.header;
        const auto found = peers.find(header.source());
        if (found == peers.end() || !needs_credit(static_cast<Body>(header.kind()))) {
            return;
        }
        Consumed& consumed = found->second.consumed;
        consumed.add(arrived.body && !arrived.packed ? arrived.body->size() : header.body_bytes());
        if (consumed.is_due()) {
            schema::CreditT returned;
            returned.messages = consumed.messages;
            returned.bytes = consumed.bytes;
            consumed = {};
            transmit(found->first, found->second, pack(returned));
        }
    }

    void take_back(const Message& message, const schema::Credit& credit) {
        const auto found = peers.find(message.source());
        if (found == peers.end() ||
            !found->second.window.give_back(credit.messages(), credit.bytes())) {
            throw WireFault(message.header(), schema::FaultCode::bad_message,
                            fmt::format("node {} gives back {} messages and {} bytes, more than "
                                        "it was sent",
                                        message.source(), credit.messages(), credit.bytes()));
        }
        flush(found->first, found->second);
    }
};

ZmqLink::ZmqLink(const Self& self, const std::string& bind, const Credentials& credentials,
                 std::size_t lendable_bytes)
    : parts_(std::make_unique<Parts>(self, credentials, lendable_bytes)) {
    check_address("listen at", bind, credentials);
    zmq::socket_t& inbound = parts_->inbound.socket(Entrance::common);
    prepare_inbound(inbound);
    if (credentials.keys) {
        guard_inbound(inbound, *credentials.keys);
        parts_->guard.start(parts_->context, inbound, *credentials.keys);
    }
    parts_->endpoint = parts_->inbound.bind(Entrance::common, bind);
}

void ZmqLink::listen_near(const std::string& bind) {
    check_address("listen at", bind, parts_->credentials);
    parts_->inbound.bind(Entrance::common, bind);
}

std::string ZmqLink::listen_apart(schema::Role role, const std::string& bind) {
    check_address("listen at", bind, parts_->credentials);
    zmq::socket_t& apart = parts_->inbound.open_apart();
    prepare_inbound(apart);
    if (parts_->credentials.keys) {
        guard_inbound(apart, *parts_->credentials.keys);
        parts_->guard.follow(parts_->context, apart);
    }
    parts_->gate.door().keep_apart(role);
    return parts_->inbound.bind(Entrance::apart, bind);
}

ZmqLink::~ZmqLink() = default;

NodeId ZmqLink::id() const {
    return parts_->self.id;
}
const std::string& ZmqLink::endpoint() const {
    return parts_->endpoint;
}
flatbuffers::Allocator* ZmqLink::body_allocator() {
    return &parts_->arena;
}
int ZmqLink::poll_fd() const {
    return parts_->inbound.poll_fd();
}
std::size_t ZmqLink::queued() const {
    return parts_->queued;
}
Traffic ZmqLink::traffic() const {
    Traffic traffic = parts_->wire.traffic();
    traffic.refused_messages = parts_->gate.door().refused();
    return traffic;
}

void ZmqLink::set_model(const ChannelModel& model) {
    parts_->wire.set_model(model);
}

void ZmqLink::add_peer(NodeId id, schema::Role role, const std::string& endpoint) {
    assert(parts_->peers.count(id) == 0);
    check_address("connect to", endpoint, parts_->credentials);
    Peer peer;
    peer.endpoint = endpoint;
    // The io process reads files of strangers, so it gets and gives copies.
    peer.is_far = !is_near(endpoint) && parts_->credentials.allows_network;
    peer.shares_memory =
        is_near(endpoint) && role != schema::Role::io && parts_->self.role != schema::Role::io;
    parts_->peers.insert_or_assign(id, std::move(peer));
    parts_->gate.door().admit(id, role);
}

void ZmqLink::compress_far(bool compress) {
    parts_->compresses_far = compress;
}
bool ZmqLink::compresses_far() const {
    return parts_->compresses_far;
}

void ZmqLink::expect(NodeId id, schema::Role role) {
    parts_->gate.door().expect(id, role);
}

void ZmqLink::on_refusal(std::function<void(const Refusal&)> report) {
    parts_->gate.door().on_refusal(std::move(report));
}

void ZmqLink::remove_peer(NodeId id) {
    if (const auto found = parts_->peers.find(id); found != parts_->peers.end()) {
        parts_->queued -= found->second.waiting.size();
        parts_->peers.erase(found);
    }
    parts_->gate.door().forget(id);
    parts_->wire.forget(id);
    parts_->arena.forget(id);
    parts_->views.erase(id);
}

void ZmqLink::send(NodeId to, Payload payload) {
    parts_->note_content(payload.kind());
    const auto found = parts_->peers.find(to);
    assert(found != parts_->peers.end());
    Wire::check_size(to, payload.kind(), payload.bytes().size());
    if (!needs_credit(payload.kind())) {
        parts_->transmit(to, found->second, payload);
        return;
    }
    Peer& peer = found->second;
    if (peer.is_full()) {
        throw NodeFault(schema::FaultCode::out_of_memory,
                        fmt::format("node {} takes nothing: {} messages of {} bytes wait for it",
                                    to, peer.waiting.size(), peer.waiting_bytes));
    }
    peer.waiting_bytes += payload.bytes().size();
    peer.waiting.push_back(std::move(payload));
    ++parts_->queued;
    parts_->flush(to, peer);
}

void ZmqLink::linger(NodeId peer, int patience_ms) {
    const auto found = parts_->peers.find(peer);
    assert(found != parts_->peers.end());
    found->second.linger_ms = patience_ms;
    if (found->second.socket.handle() != nullptr) {
        found->second.socket.set(zmq::sockopt::linger, patience_ms);
    }
}

std::optional<Message> ZmqLink::receive() {
    parts_->gate.count_strangers(parts_->guard.strangers(), parts_->endpoint);
    parts_->has_more = false;
    for (int unreturned = 0; unreturned < max_unreturned; ++unreturned) {
        zmq::message_t head;
        const std::optional<Entrance> entrance = parts_->inbound.take(head);
        if (!entrance) {
            return std::nullopt;
        }
        const std::optional<Arrived> arrived =
            parts_->gate.receive(parts_->inbound.socket(*entrance), *entrance, head);
        if (!arrived) {
            continue;
        }
        parts_->count_consumed(*arrived);
        Message message = parts_->read(*arrived);
        if (message.kind() == Body::Connected) {
            parts_->gate.door().connect(message.source());
        }
        const auto* credit = message.as<schema::Credit>();
        if (credit == nullptr) {
            parts_->note_content(message.kind());
            return message;
        }
        parts_->take_back(message, *credit);
    }
    parts_->inbound.change_turns();  // A flood at one socket delays no message at the other.
    come_again();
    return std::nullopt;
}

void ZmqLink::come_again() {
    parts_->has_more = true;
}

bool ZmqLink::has_more() const {
    return parts_->has_more;
}

bool ZmqLink::wait(int timeout_ms) {
    return parts_->inbound.wait(timeout_ms);
}

bool ZmqLink::takes_more(NodeId peer) const {
    const auto found = parts_->peers.find(peer);
    assert(found != parts_->peers.end());
    return found->second.waiting.empty();
}

}  // namespace pxpl5::bus
