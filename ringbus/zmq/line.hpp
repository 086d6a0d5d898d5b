// A port for lines from other computers, and such a line: letters beside the ring.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ringbus/zmq/credentials.hpp"

namespace pxpl5::bus {

/// Bytes of the largest letter. Larger ones are not received.
inline constexpr std::size_t max_letter_bytes = std::size_t{4} << 20;

using Letter = std::vector<std::uint8_t>;

/// The port at which a host waits for lines. Only who proves the session's key gets a letter
/// through, unless the credentials allow tcp without encryption.
class LinePort {
  public:
    /// listen  An IPv4 address of this computer, or 0.0.0.0.
    /// port    0: a free one.
    /// Throws std::runtime_error if address or port cannot be used.
    LinePort(const std::string& listen, int port, const Credentials& credentials);
    ~LinePort();
    LinePort(const LinePort&) = delete;
    LinePort& operator=(const LinePort&) = delete;

    int port() const;
    /// Edge-triggered: call receive() until it returns nothing, then wait.
    int poll_fd() const;

    struct Received {
        std::string from;  ///< The line, for send().
        Letter letter;
    };
    /// The next letter. Messages of several parts are dropped and counted.
    std::optional<Received> receive();
    /// A line that has gone gets nothing.
    void send(const std::string& to, const Letter& letter);

    /// Messages that were dropped, and strangers().
    std::uint64_t refused() const;
    /// Connections that did not prove the key. One that ended before it had to is not counted: a
    /// line that tries several addresses makes and ends some itself.
    std::uint64_t strangers() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

/// A line to the port of a host.
class Line {
  public:
    /// endpoint  "tcp://10.0.0.1:4711".
    Line(const std::string& endpoint, const Credentials& credentials);
    ~Line();
    Line(const Line&) = delete;
    Line& operator=(const Line&) = delete;

    /// Edge-triggered, as of LinePort. The second belongs to is_connected().
    int poll_fd() const;
    int event_fd() const;

    std::optional<Letter> receive();
    void send(const Letter& letter);

    /// False before the first handshake, and while the host does not answer: ZeroMQ asks it every
    /// 250 ms, and gives up after 750 ms.
    bool is_connected();
    /// True if the line has been lost once. It may go to another program at the same address now,
    /// which has not got the letters from before.
    bool was_lost() const;
    /// Letters that are not sent yet are never sent.
    void drop_unsent();
    /// True if the host, or another program at its address, has refused the key.
    bool was_refused() const;

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace pxpl5::bus
