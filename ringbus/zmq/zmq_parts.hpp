// ZeroMQ sockets of a link, and the parts of a message.
#pragma once

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "ringbus/message.hpp"
#include "ringbus/zmq/credentials.hpp"

namespace pxpl5::bus {

inline constexpr std::string_view ipc_scheme = "ipc://";
inline constexpr std::string_view tcp_scheme = "tcp://";

/// A context whose received buffers are aligned.
zmq::context_t make_context();

/// Sets the options of a new socket: linger 0 and no high-water mark.
void prepare(zmq::socket_t& socket);

/// True if the address is a socket in a folder of this computer.
bool is_near(const std::string& address);

/// Throws std::invalid_argument unless `address` is within the reach of `credentials`, and
/// protected by its folder or by keys.
///
/// verb   "listen at" or "connect to", for the error.
void check_address(const char* verb, const std::string& address, const Credentials& credentials);

/// A ZeroMQ part that shares the payload's bytes.
zmq::message_t part_of(const Payload& payload);

/// The verified message.
Message message_of(const schema::Header& header, const std::shared_ptr<zmq::message_t>& body);

/// Calls ZeroMQ again after a signal.
template <typename Call>
auto uninterrupted(const Call& call) {
    while (true) {
        try {
            return call();
        } catch (const zmq::error_t& error) {
            if (error.num() != EINTR) {
                throw;
            }
        }
    }
}

/// A ZeroMQ part with a header and `extra`.
template <typename Extra>
zmq::message_t part_of(const schema::Header& header, const Extra& extra) {
    zmq::message_t part(sizeof header + sizeof extra);
    std::memcpy(part.data(), &header, sizeof header);
    std::memcpy(part.data<std::uint8_t>() + sizeof header, &extra, sizeof extra);
    return part;
}

/// The bytes behind the header in the first part, if they have the size of an Extra.
template <typename Extra>
std::optional<Extra> extra_of(const zmq::message_t& head) {
    if (head.size() != sizeof(schema::Header) + sizeof(Extra)) {
        return std::nullopt;
    }
    Extra extra;
    std::memcpy(&extra, head.data<std::uint8_t>() + sizeof(schema::Header), sizeof extra);
    return extra;
}

}  // namespace pxpl5::bus
