// The port at which other computers join, and strangers at it.
#include "ringbus/zmq/line.hpp"

#include <doctest/doctest.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <zmq.hpp>

#include "ringbus/zmq/guard.hpp"
#include "tests/ringbus/tcp_stream.hpp"

using namespace pxpl5::bus;
using pxpl5::test::RecordingProxy;
using pxpl5::test::Stream;
using pxpl5::test::stream_patience_ms;

namespace {

const Letter hello = {1, 2, 3}, answer = {4, 5};

std::string at(int port) {
    return "tcp://127.0.0.1:" + std::to_string(port);
}

/// A port, with the key of one session.
struct Host {
    Credentials credentials = make_credentials(Protection::curve, Reach::network);
    LinePort port{"127.0.0.1", 0, credentials};

    /// The next letter.
    LinePort::Received next() {
        for (;;) {
            if (auto received = port.receive()) {
                return *received;
            }
            pollfd letters{port.poll_fd(), POLLIN, 0};
            REQUIRE(poll(&letters, 1, stream_patience_ms) == 1);
        }
    }
    /// A line of this session gets its letter through, and the answer back.
    void check_works() {
        Line line(at(port.port()), credentials);
        line.send(hello);
        const LinePort::Received received = next();
        CHECK(received.letter == hello);
        port.send(received.from, answer);
        std::optional<Letter> got;
        while (!(got = line.receive())) {
            pollfd letters{line.poll_fd(), POLLIN, 0};
            REQUIRE(poll(&letters, 1, stream_patience_ms) == 1);
        }
        CHECK(*got == answer);
    }
    /// Strangers do not wake a port.
    void await_strangers(std::uint64_t count) {
        const auto deadline =
            std::chrono::steady_clock::now() + std::chrono::milliseconds(stream_patience_ms);
        while (port.strangers() < count) {
            CHECK(!port.receive());
            REQUIRE(std::chrono::steady_clock::now() < deadline);
            std::this_thread::yield();
        }
        CHECK(!port.receive());
        CHECK(port.strangers() == count);
        CHECK(port.refused() == count);
    }
};

/// A client of ZeroMQ with any keys, which sends a letter.
class Client {
  public:
    Client(const CurveKeys& own, const std::string& server_key) {
        socket_.set(zmq::sockopt::linger, 0);
        guard_outbound(socket_, own);
        socket_.set(zmq::sockopt::curve_serverkey, server_key);
    }
    void connect_to(const std::string& endpoint) { socket_.connect(endpoint); }
    void send(int parts) {
        for (int left = parts - 1; left >= 0; --left) {
            socket_.send(zmq::buffer(hello),
                         left > 0 ? zmq::send_flags::sndmore : zmq::send_flags::none);
        }
    }

  private:
    zmq::context_t context_{1};
    zmq::socket_t socket_{context_, zmq::socket_type::dealer};
};

}  // namespace

TEST_SUITE("ringbus/zmq/zmq_link_line") {
    TEST_CASE("letters pass both ways, and connections that say nothing are no strangers") {
        Host host;
        for (int i = 0; i < 20; ++i) {  // As a line that looks for the way.
            const Stream probe(host.port.port());
        }
        host.check_works();
        host.check_works();
        CHECK(host.port.strangers() == 0);
        CHECK(host.port.refused() == 0);
    }

    TEST_CASE("a line without keys gets no letter through, and is counted") {
        Host host;
        // ZeroMQ's own client may close the connection before the port has read why, and then
        // counts as one that was cut. So this client waits until the port closes.
        const std::string mechanism = std::string("NULL") + std::string(16, '\0');
        const std::string greeting = std::string("\xff") + std::string(8, '\0') + "\x7f\x03" +
                                     std::string(1, '\0') + mechanism + std::string(32, '\0');
        REQUIRE(greeting.size() == 64);
        const Stream stream(host.port.port());
        stream.send(greeting);
        CHECK(stream.read_all().size() <= 64);
        host.await_strangers(1);
        host.check_works();
    }

    TEST_CASE("a line without the key gets no letter through, and is counted") {
        Host host;
        const Credentials other = make_credentials(Protection::curve, Reach::network);
        std::uint64_t counted = 0;
        for (const std::string& server : {host.credentials.keys->open, other.keys->open}) {
            Client client(*other.keys, server);
            client.connect_to(at(host.port.port()));
            client.send(1);
            host.await_strangers(++counted);
        }
        host.check_works();
    }

    TEST_CASE("bytes of other protocols get no more than a greeting, and are counted") {
        Host host;
        std::uint64_t counted = 0;
        const std::string greeting_1 = {1, 0}, hello_1 = {6, 0, 'h', 'e', 'l', 'l', 'o'};
        for (const std::string& bytes :
             {std::string("GET / HTTP/1.1\r\nHost: x\r\n\r\n"), greeting_1 + hello_1,
              std::string("\xff") + std::string(300, '\x7f')}) {
            const Stream stream(host.port.port());
            stream.send(bytes);
            CHECK(stream.read_all().size() <= 64);
            host.await_strangers(++counted);
        }
        host.check_works();
    }

    TEST_CASE("a recorded line, played again, is a stranger") {
        Host host;
        std::string bytes;
        {
            RecordingProxy recording(host.port.port());
            {
                Line line(at(recording.port()), host.credentials);
                line.send(hello);
                CHECK(host.next().letter == hello);
            }
            bytes = recording.take();
        }
        CHECK(bytes.size() > 300);
        const Stream again(host.port.port());
        again.send(bytes);
        again.read_all();
        host.await_strangers(1);
        host.check_works();
    }

    TEST_CASE("messages of several parts are dropped and counted") {
        Host host;
        Client client(*host.credentials.keys, host.credentials.keys->open);
        client.connect_to(at(host.port.port()));
        client.send(2);
        client.send(1);
        CHECK(host.next().letter == hello);
        CHECK(host.port.refused() == 1);
        CHECK(host.port.strangers() == 0);
    }

    TEST_CASE("an address or a port that cannot be used is named") {
        const Host host;
        const std::string port = std::to_string(host.port.port());
        CHECK_THROWS_WITH_AS(
            LinePort("127.0.0.1", host.port.port(), host.credentials),
            doctest::Contains(("cannot listen at tcp://127.0.0.1:" + port).c_str()),
            std::runtime_error);
    }
}
