// A ZeroMQ socket with which a test sends any bytes to a link.
#pragma once

#include <string>
#include <zmq.hpp>

#include "ringbus/wire.hpp"
#include "ringbus/zmq/zmq_link.hpp"

namespace pxpl5::test {

class RawPeer {
  public:
    explicit RawPeer(const std::string& address) {
        socket_.set(zmq::sockopt::linger, 0);
        socket_.set(zmq::sockopt::sndhwm, 0);  // A flood waits here and blocks no test.
        socket_.connect(address);
    }

    void send(const bus::schema::Header& header, const bus::Payload& body) {
        socket_.send(zmq::buffer(&header, sizeof header), zmq::send_flags::sndmore);
        socket_.send(zmq::buffer(body.bytes().data(), body.bytes().size()));
    }

    /// Sends `body` with a header that has `number` and the times of the arguments.
    void send_as(bus::NodeId source, bus::NodeId to, std::uint64_t number, const bus::Payload& body,
                 std::uint64_t arrival_ns = 0, std::uint64_t clock = 1) {
        send({bus::header_magic, bus::protocol_version, static_cast<std::uint16_t>(body.kind()),
              source, to, 0, 0, number, body.bytes().size(), 0, arrival_ns, clock},
             body);
    }

    zmq::socket_t& socket() { return socket_; }

  private:
    zmq::context_t context_{1};
    zmq::socket_t socket_{context_, zmq::socket_type::push};
};

/// Receives nothing until the link has refused `count` messages.
inline void await_refusals(bus::ZmqLink& link, std::uint64_t count) {
    constexpr int patience_ms = 30000;
    while (link.traffic().refused_messages < count) {
        REQUIRE(!link.receive());
        if (link.traffic().refused_messages < count) {
            REQUIRE(link.wait(patience_ms));
        }
    }
    CHECK(link.traffic().refused_messages == count);
}

}  // namespace pxpl5::test
