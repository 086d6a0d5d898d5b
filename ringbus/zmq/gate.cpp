#include "ringbus/zmq/gate.hpp"

#include <fmt/core.h>

#include <cstring>
#include <utility>

#include "ringbus/wire.hpp"
#include "ringbus/zmq/zmq_parts.hpp"

namespace pxpl5::bus {

std::optional<Arrived> Gate::receive(zmq::socket_t& inbound, Entrance entrance,
                                     const zmq::message_t& head) {
    Arrived arrived;
    arrived.entrance = entrance;
    std::size_t parts = 1;
    for (bool more = head.more(); more; ++parts) {
        arrived.body = std::make_shared<zmq::message_t>();
        static_cast<void>(
            uninterrupted([&] { return inbound.recv(*arrived.body, zmq::recv_flags::none); }));
        more = arrived.body->more();
    }
    if (!has_header(arrived, head, parts) || !door_.lets_in(arrived.header, entrance)) {
        return std::nullopt;
    }
    if (door_.is_expected(arrived.header.source()) && !may_join(arrived)) {
        return std::nullopt;
    }
    return arrived;
}

/// Returns false for bytes that have no header of this protocol, and so no sender.
bool Gate::has_header(Arrived& arrived, const zmq::message_t& head, std::size_t parts) {
    arrived.place = extra_of<ArenaPlace>(head);
    arrived.offer = extra_of<ArenaOffer>(head);
    arrived.packed = extra_of<PackedBody>(head);
    const bool known =
        head.size() == sizeof(schema::Header) || arrived.place || arrived.offer || arrived.packed;
    const std::size_t wanted = arrived.place ? 1 : 2;
    if (!known || parts != wanted) {
        door_.refuse(RefusalReason::no_message,
                     fmt::format("a message of {} parts with a header of {} bytes, expected {} "
                                 "parts and {} bytes",
                                 parts, head.size(), wanted, sizeof(schema::Header)));
        return false;
    }
    std::memcpy(&arrived.header, head.data(), sizeof arrived.header);
    if (!Wire::is_ours(arrived.header)) {
        door_.refuse(
            RefusalReason::no_message,
            fmt::format("a message with magic {:08x} of version {}, expected {:08x} and {}",
                        arrived.header.magic(), arrived.header.version(), header_magic,
                        protocol_version));
        return false;
    }
    return true;
}

/// Returns whether the message is a Hello with the secret.
bool Gate::may_join(const Arrived& arrived) {
    try {
        if (arrived.place || arrived.packed) {
            throw BadMessage("a Hello whose body is elsewhere, or compressed");
        }
        const Message message = message_of(arrived.header, arrived.body);
        if (!door_.lets_join(arrived.header, *message.as<schema::Hello>(), secret_)) {
            return false;
        }
    } catch (const BadMessage& bad) {  // Any process may use the number of an expected node.
        door_.refuse(RefusalReason::no_message, bad.what());
        return false;
    }
    auto& message = *flatbuffers::GetMutableRoot<schema::Message>(arrived.body->data());
    auto& hello = *static_cast<schema::Hello*>(message.mutable_body());
    *hello.mutable_secret() = schema::Secret();
    return true;
}

void Gate::count_strangers(std::uint64_t strangers, const std::string& endpoint) {
    if (strangers != strangers_) {
        door_.refuse(RefusalReason::stranger,
                     "a connection to " + endpoint + " without the key of this session",
                     strangers - std::exchange(strangers_, strangers));
    }
}

}  // namespace pxpl5::bus
