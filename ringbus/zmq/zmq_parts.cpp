#include "ringbus/zmq/zmq_parts.hpp"

#include <fmt/core.h>

#include <latch>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

namespace pxpl5::bus {

namespace {

/// Option 10 of a context: without zero-copy receive, buffers come from malloc and are aligned.
constexpr int zero_copy_receive = 10;
constexpr std::string_view loopback = "tcp://127.0.0.1:";

/// Threads that ZeroMQ starts with the first socket of a context.
constexpr std::size_t context_threads = 2;

/// Throws std::runtime_error if this process may not start the threads of a context. ZeroMQ would
/// abort.
void try_threads() {
    std::latch all_started(1);
    std::vector<std::jthread> tried;  // Ends before the latch.
    try {
        while (tried.size() < context_threads) {
            tried.emplace_back([&all_started] { all_started.wait(); });
        }
    } catch (const std::system_error& error) {
        all_started.count_down();
        throw std::runtime_error(
            fmt::format("cannot start thread {} of the {} that ZeroMQ needs: {}. Raise the limit "
                        "of this user's threads (ulimit -u) or of the control group (pids.max)",
                        tried.size() + 1, context_threads, error.code().message()));
    }
    all_started.count_down();
}

void release_payload(void*, void* hint) {
    delete static_cast<Payload*>(hint);
}

}  // namespace

zmq::context_t make_context() {
    try_threads();
    zmq::context_t context(1);
    zmq_ctx_set(context.handle(), zero_copy_receive, 0);
    return context;
}

// Linger 0 comes first, because closing could hang otherwise. Credit bounds the queues instead of
// the high-water mark, which would drop or block.
void prepare(zmq::socket_t& socket) {
    socket.set(zmq::sockopt::linger, 0);
    socket.set(zmq::sockopt::sndhwm, 0);
    socket.set(zmq::sockopt::rcvhwm, 0);
    socket.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(max_body_bytes));
}

bool is_near(const std::string& address) {
    return address.compare(0, ipc_scheme.size(), ipc_scheme) == 0;
}

void check_address(const char* verb, const std::string& address, const Credentials& credentials) {
    const auto starts_with = [&](std::string_view prefix) {
        return address.compare(0, prefix.size(), prefix) == 0;
    };
    // The file system protects an ipc path. Nothing protects an abstract name, ipc://@...
    const bool is_tcp =
        starts_with(credentials.allows_network ? tcp_scheme : std::string_view(loopback));
    if (!is_tcp && !starts_with("ipc:///")) {
        throw std::invalid_argument(fmt::format(
            "refusing to {} {}: {}", verb, address,
            credentials.allows_network
                ? "only ipc:///path and tcp://address:port are known"
                : "only ipc:///path and tcp://127.0.0.1:port are private to this computer"));
    }
    if (is_tcp && !credentials.keys && !credentials.allows_plain_tcp) {
        throw std::invalid_argument(fmt::format(
            "refusing to {} {}: without keys for CURVE, any user of this {} could take part", verb,
            address, credentials.allows_network ? "network" : "computer"));
    }
}

zmq::message_t part_of(const Payload& payload) {
    auto* hint = new Payload(payload);
    const auto bytes = hint->bytes();
    return zmq::message_t(const_cast<std::uint8_t*>(bytes.data()), bytes.size(), &release_payload,
                          hint);
}

// Very small parts are unaligned inside ZeroMQ's own struct and are copied.
Message message_of(const schema::Header& header, const std::shared_ptr<zmq::message_t>& body) {
    const auto* bytes = static_cast<const std::uint8_t*>(body->data());
    if (reinterpret_cast<std::uintptr_t>(bytes) % body_alignment == 0) {
        return {header, {bytes, body->size()}, body};
    }
    auto copy = std::make_shared<std::vector<std::uint64_t>>(body->size() / body_alignment + 1);
    std::memcpy(copy->data(), bytes, body->size());
    return {header, {reinterpret_cast<const std::uint8_t*>(copy->data()), body->size()}, copy};
}

}  // namespace pxpl5::bus
