// Strangers at a tcp port: they get nothing and change nothing.
#include <doctest/doctest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <string>
#include <thread>
#include <zmq.hpp>

#include "ringbus/zmq/guard.hpp"
#include "tests/ringbus/large_bodies.hpp"
#include "tests/ringbus/tcp_stream.hpp"
#include "tests/ringbus/test_zmq_link_peer.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::contains;
using pxpl5::test::next_of;
using pxpl5::test::port_of;
using pxpl5::test::RecordingProxy;
using pxpl5::test::Stream;
using pxpl5::test::stream_patience_ms;
using schema::Role;

namespace {

constexpr const char* any_port = "tcp://127.0.0.1:*";
constexpr NodeId gp_id = 1;

Payload remove_surface(std::uint16_t number) {
    schema::RemoveSurfaceT body;
    body.surface = number;
    return pack(body);
}

/// A host and a GP over tcp, with the keys of one session.
struct Session {
    Credentials credentials = make_credentials(Protection::curve);
    ZmqLink host{{host_id, Role::host}, any_port, credentials};
    ZmqLink gp{{gp_id, Role::gp}, any_port, credentials};
    std::vector<std::string> named;

    Session() {
        host.add_peer(gp_id, Role::gp, gp.endpoint());
        gp.add_peer(host_id, Role::host, host.endpoint());
        gp.on_refusal([this](const Refusal& refusal) { named.push_back(refusal.text); });
        check_works(1);
    }

    void check_works(std::uint16_t number) {
        host.send(gp_id, remove_surface(number));
        CHECK(next_of(gp).as<schema::RemoveSurface>()->surface() == number);
    }

    /// Waits until the GP has counted so many strangers. They do not wake a link.
    void await_strangers(std::uint64_t count) {
        const auto deadline =
            std::chrono::steady_clock::now() + std::chrono::milliseconds(stream_patience_ms);
        while (gp.traffic().refused_messages < count) {
            REQUIRE(!gp.receive());
            REQUIRE(std::chrono::steady_clock::now() < deadline);
            std::this_thread::yield();
        }
        CHECK(!gp.receive());
        CHECK(gp.traffic().refused_messages >= count);
    }
};

/// A PUSH socket that sends an order to the GP, as the host would.
class Forger {
  public:
    explicit Forger(const std::optional<CurveKeys>& own, const std::string& server_key) {
        socket_.set(zmq::sockopt::linger, 0);
        if (own) {
            socket_.set(zmq::sockopt::curve_serverkey, server_key);
            socket_.set(zmq::sockopt::curve_publickey, own->open);
            socket_.set(zmq::sockopt::curve_secretkey, own->secret);
        }
    }
    void send_to(const std::string& endpoint) {
        socket_.connect(endpoint);
        const Payload order = pack(schema::ShutdownT{});
        const schema::Header header(header_magic, protocol_version,
                                    static_cast<std::uint16_t>(order.kind()), host_id, gp_id, 0, 0,
                                    1, order.bytes().size(), 0, 0, 1);
        socket_.send(zmq::buffer(&header, sizeof header), zmq::send_flags::sndmore);
        socket_.send(zmq::buffer(order.bytes().data(), order.bytes().size()));
    }

  private:
    zmq::context_t context_{1};
    zmq::socket_t socket_{context_, zmq::socket_type::push};
};

}  // namespace

TEST_SUITE("ringbus/zmq/zmq_link_curve") {
    TEST_CASE("nodes of a session exchange messages over tcp, large ones too") {
        Session session;
        for (std::uint32_t i = 0; i < 20; ++i) {
            session.host.send(gp_id, test::large_slices(session.host.body_allocator(), 100'000, i));
            CHECK(test::is_whole(next_of(session.gp), 100'000, i));
        }
        session.gp.send(host_id, pack(schema::VolumeReadyT{}));
        CHECK(next_of(session.host).kind() == Body::VolumeReady);
        CHECK(session.gp.traffic().refused_messages == 0);
        CHECK(session.host.traffic().refused_messages == 0);
    }

    TEST_CASE("tcp without keys is refused, unless it is allowed by name") {
        const Credentials none = make_credentials(Protection::files);
        CHECK_THROWS_WITH_AS(
            ZmqLink({gp_id, Role::gp}, any_port, none),
            "refusing to listen at tcp://127.0.0.1:*: without keys for CURVE, any user of this "
            "computer could take part",
            std::invalid_argument);
        ZmqLink near({gp_id, Role::gp}, any_port, make_credentials(Protection::plain_tcp));
        CHECK(contains(near.endpoint(), "tcp://127.0.0.1:"));
    }

    TEST_CASE("the socket for io processes asks for the session's key, too") {
        const Credentials credentials = make_credentials(Protection::curve);
        ZmqLink host({host_id, Role::host}, any_port, credentials);
        const std::string apart = host.listen_apart(Role::io, any_port);
        CHECK(apart != host.endpoint());
        ZmqLink io({gp_id, Role::io}, any_port, credentials);
        host.add_peer(gp_id, Role::io, io.endpoint());
        io.add_peer(host_id, Role::host, apart);
        Forger forger(std::nullopt, credentials.keys->open);
        forger.send_to(apart);
        const auto deadline =
            std::chrono::steady_clock::now() + std::chrono::milliseconds(stream_patience_ms);
        while (host.traffic().refused_messages < 1) {
            REQUIRE(!host.receive());
            REQUIRE(std::chrono::steady_clock::now() < deadline);
            std::this_thread::yield();
        }
        io.send(host_id, pack(schema::IoDoneT{}));
        CHECK(next_of(host).kind() == Body::IoDone);
    }

    TEST_CASE("a stranger without the session's key changes nothing, and is counted") {
        Session session;
        const Credentials other = make_credentials(Protection::curve);
        const std::string& key = session.credentials.keys->open;
        Forger no_key(std::nullopt, key), own_key(other.keys, key),
            wrong_server(session.credentials.keys, other.keys->open);
        std::uint64_t counted = 0;
        for (Forger* forger : {&no_key, &own_key, &wrong_server}) {
            forger->send_to(session.gp.endpoint());
            session.await_strangers(++counted);
        }
        REQUIRE(session.named.size() == 1);
        CHECK(contains(session.named[0],
                       "a connection to " + session.gp.endpoint() + " without the key"));
        session.check_works(2);
    }

    TEST_CASE("bytes of other protocols get no answer that says anything, and are counted") {
        Session session;
        std::uint64_t counted = 0;
        // A message of ZMTP 1.0, which has no mechanisms. An HTTP POST can look like this.
        const std::string greeting_1 = {1, 0}, hello_1 = {6, 0, 'h', 'e', 'l', 'l', 'o'};
        for (const std::string& bytes :
             {std::string("GET / HTTP/1.1\r\nHost: x\r\n\r\n"), greeting_1 + hello_1,
              std::string(200, '\0'), std::string("\xff") + std::string(300, '\x7f')}) {
            const Stream stream(port_of(session.gp.endpoint()));
            stream.send(bytes);
            shutdown(stream.fd(), SHUT_WR);
            CHECK(stream.read_all().size() <= 64);  // At most a greeting.
            session.await_strangers(++counted);
        }
        REQUIRE(session.named.size() == 1);
        CHECK(contains(session.named[0], "without the key"));
        session.check_works(2);
    }

    TEST_CASE("a recorded connection, played again, changes nothing") {
        Session session;
        RecordingProxy recording(port_of(session.gp.endpoint()));
        {
            Forger host(session.credentials.keys, session.credentials.keys->open);
            host.send_to("tcp://127.0.0.1:" + std::to_string(recording.port()));
            CHECK(next_of(session.gp).kind() == Body::Shutdown);  // As if from the host.
        }
        const std::string bytes = recording.take();
        CHECK(bytes.size() > 300);
        CHECK(!contains(bytes, "PXP5"));  // Nothing is readable.
        const Stream again(port_of(session.gp.endpoint()));
        again.send(bytes);
        shutdown(again.fd(), SHUT_WR);
        again.read_all();
        session.await_strangers(1);
        CHECK(session.gp.traffic().received_messages == 2);
    }

    TEST_CASE("another user of the computer gets nothing from a port") {
        if (geteuid() != 0) {
            MESSAGE("skipped: only root can act as another user");
            return;
        }
        Session session;
        const pid_t child = fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            if (setgid(65534) != 0 || setuid(65534) != 0) {
                _exit(1);
            }
            Forger forger(std::nullopt, "");
            forger.send_to(session.gp.endpoint());
            while (true) {
                pause();
            }
        }
        session.await_strangers(1);
        kill(child, SIGKILL);
        int status = 0;
        REQUIRE(waitpid(child, &status, 0) == child);
        CHECK(WIFSIGNALED(status));
        session.check_works(2);
    }
}
