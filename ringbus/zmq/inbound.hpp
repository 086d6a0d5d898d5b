// The inbound sockets of a link: one for all nodes, and a second one for nodes of one role.
#pragma once

#include <optional>
#include <string>
#include <zmq.hpp>

#include "ringbus/door.hpp"

namespace pxpl5::bus {

class Inbound {
  public:
    explicit Inbound(zmq::context_t& context)
        : context_(context), common_(context, zmq::socket_type::pull) {}
    ~Inbound();
    Inbound(const Inbound&) = delete;
    Inbound& operator=(const Inbound&) = delete;

    /// Opens the socket for one role. Throws std::runtime_error.
    zmq::socket_t& open_apart();
    /// Requires open_apart() for Entrance::apart.
    zmq::socket_t& socket(Entrance entrance) {
        return entrance == Entrance::apart ? *apart_ : common_;
    }
    /// Binds a socket to one more address. Returns the address. Throws std::runtime_error.
    std::string bind(Entrance entrance, const std::string& address);

    /// Takes the first part of a message that has arrived. The second socket has its turn when the
    /// first is empty. Returns nothing if both are empty.
    std::optional<Entrance> take(zmq::message_t& head);
    /// Lets the next take() begin with the other socket, until both are empty.
    void change_turns() { is_apart_first_ = !is_apart_first_; }

    /// See ZmqLink::poll_fd() and ZmqLink::wait().
    int poll_fd() const;
    bool wait(int timeout_ms);

  private:
    bool take_from(Entrance entrance, zmq::message_t& head);

    zmq::context_t& context_;
    zmq::socket_t common_;
    std::optional<zmq::socket_t> apart_;
    int both_ = -1;  ///< An epoll set of both sockets.
    bool is_apart_first_ = false;
};

}  // namespace pxpl5::bus
