#include "ringbus/zmq/line.hpp"

#include <fmt/core.h>

#include <cstring>
#include <stdexcept>
#include <zmq.hpp>

#include "ringbus/zmq/guard.hpp"
#include "ringbus/zmq/zmq_link.hpp"
#include "ringbus/zmq/zmq_parts.hpp"

namespace pxpl5::bus {

namespace {

constexpr int ask_ms = 250;     // Between two questions whether the other side is there.
constexpr int silent_ms = 750;  // Without an answer: the other side is gone.
// Handshakes that fail without a reason, until the key counts as refused.
constexpr int max_failures = 3;
constexpr const char* line_events_address = "inproc://pxpl5-line-events";

void prepare_line(zmq::socket_t& socket) {
    prepare(socket);
    socket.set(zmq::sockopt::linger, closing_ms);
    socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(max_letter_bytes));
    socket.set(zmq::sockopt::heartbeat_ivl, ask_ms);
    socket.set(zmq::sockopt::heartbeat_timeout, silent_ms);
    socket.set(zmq::sockopt::heartbeat_ttl, silent_ms);
}

Letter letter_of(const zmq::message_t& bytes) {
    return {bytes.data<std::uint8_t>(), bytes.data<std::uint8_t>() + bytes.size()};
}

bool take(zmq::socket_t& socket, zmq::message_t& part) {
    return uninterrupted([&] { return socket.recv(part, zmq::recv_flags::dontwait).has_value(); });
}

}  // namespace

struct LinePort::Parts {
    Guard guard;  // Outlives the context, which ends its thread.
    zmq::context_t context = make_context();
    zmq::socket_t socket{context, zmq::socket_type::router};
    int port = 0;
    std::uint64_t bad_letters = 0;
};

LinePort::LinePort(const std::string& listen, int port, const Credentials& credentials)
    : parts_(std::make_unique<Parts>()) {
    prepare_line(parts_->socket);
    if (credentials.keys) {
        guard_inbound(parts_->socket, *credentials.keys);
        parts_->guard.start(parts_->context, parts_->socket, *credentials.keys, Counted::not_cut);
    }
    const std::string address =
        fmt::format("tcp://{}:{}", listen, port == 0 ? "*" : std::to_string(port));
    try {
        uninterrupted([&] { parts_->socket.bind(address); });
    } catch (const zmq::error_t& error) {
        throw std::runtime_error(
            fmt::format("cannot listen at {} for other computers: {}", address, error.what()));
    }
    const std::string bound = parts_->socket.get(zmq::sockopt::last_endpoint);
    parts_->port = std::stoi(bound.substr(bound.rfind(':') + 1));
}

LinePort::~LinePort() = default;

int LinePort::port() const {
    return parts_->port;
}
int LinePort::poll_fd() const {
    return static_cast<int>(parts_->socket.get(zmq::sockopt::fd));
}
std::uint64_t LinePort::refused() const {
    return parts_->bad_letters + strangers();
}
std::uint64_t LinePort::strangers() const {
    return parts_->guard.strangers();
}

std::optional<LinePort::Received> LinePort::receive() {
    zmq::message_t from, bytes;
    while (take(parts_->socket, from)) {
        int parts = 1;
        for (bool more = from.more(); more; ++parts) {
            more = take(parts_->socket, bytes) && bytes.more();
        }
        if (parts == 2) {
            return Received{from.to_string(), letter_of(bytes)};
        }
        ++parts_->bad_letters;
    }
    return std::nullopt;
}

void LinePort::send(const std::string& to, const Letter& letter) {
    uninterrupted([&] { return parts_->socket.send(zmq::buffer(to), zmq::send_flags::sndmore); });
    uninterrupted([&] { return parts_->socket.send(zmq::buffer(letter), zmq::send_flags::none); });
}

struct Line::Parts {
    zmq::context_t context = make_context();
    zmq::socket_t socket{context, zmq::socket_type::dealer};
    zmq::socket_t events{context, zmq::socket_type::pair};
    bool is_connected = false, was_lost = false, was_refused = false;
    int failures = 0;  ///< Handshakes that failed without a reason.
};

Line::Line(const std::string& endpoint, const Credentials& credentials)
    : parts_(std::make_unique<Parts>()) {
    prepare_line(parts_->socket);
    prepare(parts_->events);
    if (credentials.keys) {
        guard_outbound(parts_->socket, *credentials.keys);
    }
    constexpr int wanted = ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_DISCONNECTED |
                           ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
                           ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;
    if (zmq_socket_monitor(parts_->socket.handle(), line_events_address, wanted) != 0) {
        throw zmq::error_t();
    }
    parts_->events.connect(line_events_address);
    uninterrupted([&] { parts_->socket.connect(endpoint); });
}

Line::~Line() {
    zmq_socket_monitor(parts_->socket.handle(), nullptr, 0);
}

int Line::poll_fd() const {
    return static_cast<int>(parts_->socket.get(zmq::sockopt::fd));
}
int Line::event_fd() const {
    return static_cast<int>(parts_->events.get(zmq::sockopt::fd));
}

std::optional<Letter> Line::receive() {
    zmq::message_t bytes;
    if (!take(parts_->socket, bytes)) {
        return std::nullopt;
    }
    return letter_of(bytes);
}

void Line::send(const Letter& letter) {
    uninterrupted([&] { return parts_->socket.send(zmq::buffer(letter), zmq::send_flags::none); });
}

bool Line::is_connected() {
    for (zmq::message_t part; take(parts_->events, part);) {
        std::uint16_t event = 0;
        if (!part.more()) {  // The second part has the address.
            continue;
        }
        std::memcpy(&event, part.data(), sizeof event);
        if (event == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
            parts_->is_connected = true;
        } else {
            parts_->is_connected = false;
            parts_->was_lost |= event == ZMQ_EVENT_DISCONNECTED;
            // Without a detail: another key of the host, or a connection that was cut.
            parts_->failures += event == ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL ? 1 : 0;
            parts_->was_refused |= event == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL ||
                                   event == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH ||
                                   parts_->failures >= max_failures;
        }
    }
    return parts_->is_connected;
}

bool Line::was_lost() const {
    return parts_->was_lost;
}

void Line::drop_unsent() {
    parts_->socket.set(zmq::sockopt::linger, 0);
}

bool Line::was_refused() const {
    return parts_->was_refused;
}

}  // namespace pxpl5::bus
