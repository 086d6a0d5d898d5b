// The gate of a socket: takes the parts of a message together and asks the door about its sender.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "ringbus/door.hpp"
#include "ringbus/zmq/arena_layout.hpp"
#include "ringbus/zmq/packed_body.hpp"

namespace pxpl5::bus {

/// A message with a lawful sender, before verification.
struct Arrived {
    schema::Header header;
    std::shared_ptr<zmq::message_t> body;  ///< Null if it is in the sender's arena.
    std::optional<ArenaPlace> place;
    std::optional<ArenaOffer> offer;
    std::optional<PackedBody> packed;  ///< `body` is compressed.
    Entrance entrance = Entrance::common;
};

class Gate {
  public:
    /// secret  Required in each Hello.
    Gate(schema::Role role, const schema::Secret& secret) : door_(role), secret_(secret) {}

    Door& door() { return door_; }

    /// Receives the other parts of the message that begins with `head`. Returns nothing if the
    /// door refuses the message. Erases the secret in a Hello, because messages are recorded.
    std::optional<Arrived> receive(zmq::socket_t& inbound, Entrance entrance,
                                   const zmq::message_t& head);
    /// Counts connections to `endpoint` that proved no key. `strangers` is their number so far.
    void count_strangers(std::uint64_t strangers, const std::string& endpoint);

  private:
    bool has_header(Arrived& arrived, const zmq::message_t& head, std::size_t parts);
    bool may_join(const Arrived& arrived);

    Door door_;
    schema::Secret secret_;
    std::uint64_t strangers_ = 0;
};

}  // namespace pxpl5::bus
