#include <doctest/doctest.h>
#include <poll.h>

#include <chrono>
#include <cstring>
#include <optional>
#include <vector>
#include <zmq.hpp>

#include "ringbus/wire.hpp"
#include "ringbus/zmq/arena.hpp"
#include "ringbus/zmq/inbound.hpp"
#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/ipc_address.hpp"
#include "tests/ringbus/large_bodies.hpp"
#include "tests/ringbus/test_zmq_link_peer.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::await_refusals;
using pxpl5::test::contains;
using pxpl5::test::ipc_address;
using pxpl5::test::next_of;
using pxpl5::test::RawPeer;
using schema::Role;

namespace {

constexpr NodeId gp_id = 1, stranger_id = 77;

/// A GP whose host is a raw peer.
struct Victim {
    ZmqLink link{{gp_id, Role::gp}, ipc_address("victim")};
    RawPeer host{link.endpoint()};
    Victim() { link.add_peer(host_id, Role::host, ipc_address("victims-host")); }
};

Payload remove_surface(std::uint16_t number) {
    schema::RemoveSurfaceT body;
    body.surface = number;
    return pack(body);
}

/// The host, which expects a GP.
struct Host {
    Credentials credentials = make_credentials(Protection::files);
    ZmqLink link{{host_id, Role::host}, ipc_address("expecting"), credentials};
    RawPeer gp{link.endpoint()};
    Host() { link.expect(gp_id, Role::gp); }

    static schema::HelloT hello() {
        schema::HelloT hello;
        hello.role = Role::gp;
        hello.endpoint = ipc_address("expected");
        hello.build = "b";
        return hello;
    }
    Payload true_hello() const {
        schema::HelloT said = hello();
        said.secret = std::make_unique<schema::Secret>(credentials.secret);
        return pack(said);
    }
};

}  // namespace

TEST_SUITE("ringbus/zmq/zmq_link_door") {
    TEST_CASE("orders of unknown nodes are dropped and change nothing") {
        Victim victim;
        schema::FetchMeshT fetch;
        std::uint64_t sent = 0;
        for (const Payload& order :
             {pack(schema::ShutdownT{}), pack(schema::SaveTraceT{}), pack(fetch),
              pack(schema::AskActivityT{}), pack(schema::CreditT{})}) {
            victim.host.send_as(stranger_id, gp_id, 0, order, ~std::uint64_t{0}, ~std::uint64_t{0});
            ++sent;
        }
        await_refusals(victim.link, sent);
        victim.host.send_as(host_id, gp_id, 0, remove_surface(5));
        CHECK(next_of(victim.link).as<schema::RemoveSurface>()->surface() == 5);
        CHECK(victim.link.traffic().received_messages == 1);
    }

    TEST_CASE("a flood of refused messages keeps no caller in receive()") {
        constexpr std::uint64_t flood = 5000;
        Victim victim;
        for (std::uint64_t n = 0; n < flood; ++n) {
            victim.host.send_as(stranger_id, gp_id, n, remove_surface(1));
        }
        victim.host.send_as(host_id, gp_id, 0, remove_surface(5));
        constexpr std::uint64_t most_of_a_call = 1024;
        std::optional<Message> message;
        while (!message) {
            constexpr int patience_ms = 30000;
            REQUIRE(victim.link.wait(patience_ms));
            const std::uint64_t before = victim.link.traffic().refused_messages;
            message = victim.link.receive();
            const std::uint64_t refused = victim.link.traffic().refused_messages - before;
            CHECK(refused <= most_of_a_call);
            CHECK(victim.link.has_more() == (refused == most_of_a_call));
        }
        CHECK(message->as<schema::RemoveSurface>()->surface() == 5);
        CHECK(victim.link.traffic().refused_messages == flood);
        CHECK_FALSE(victim.link.has_more());
    }

    TEST_CASE("a peer's message that its role may not send is dropped and has no number") {
        Victim victim;
        victim.link.add_peer(2, Role::gp, ipc_address("other-gp"));
        RawPeer other(victim.link.endpoint());
        other.send_as(2, gp_id, 0, pack(schema::ShutdownT{}));
        other.send_as(2, gp_id, 0, remove_surface(5));
        await_refusals(victim.link, 2);
        schema::BeginFrameT begin;
        begin.draw = std::make_unique<schema::DrawFrameT>(test::example_draw());
        begin.assignment = {0, 0, 0, 0, 0, 0};
        other.send_as(2, gp_id, 0, pack(begin));
        CHECK(next_of(victim.link).kind() == Body::BeginFrame);
    }

    TEST_CASE("a number that is repeated or far ahead is refused and not adopted") {
        Victim victim;
        victim.host.send_as(host_id, gp_id, 1'000'000, remove_surface(1));
        CHECK_THROWS_WITH_AS(next_of(victim.link),
                             "message 1000000 from node 0 came where 0 was due", WireFault);
        victim.host.send_as(host_id, gp_id, 2, remove_surface(1));  // One may be missing at first.
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.host.send_as(host_id, gp_id, 0, remove_surface(1));
        CHECK(next_of(victim.link).header().sequence() == 0);
        victim.host.send_as(host_id, gp_id, 0, remove_surface(1));
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.host.send_as(host_id, gp_id, 2 + max_missing, remove_surface(1));
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.host.send_as(host_id, gp_id, ~std::uint64_t{0}, remove_surface(1));
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.host.send_as(host_id, gp_id, 100, remove_surface(1));
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.host.send_as(host_id, gp_id, 1, remove_surface(1));
        CHECK(next_of(victim.link).header().sequence() == 1);
    }

    TEST_CASE("a lost message is reported once, and the next is taken") {
        Victim victim;
        victim.host.send_as(host_id, gp_id, 1, remove_surface(1));
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.host.send_as(host_id, gp_id, 2, remove_surface(1));
        CHECK(next_of(victim.link).header().sequence() == 2);
        victim.host.send_as(host_id, gp_id, 3 + max_missing, remove_surface(1));
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.host.send_as(host_id, gp_id, 4 + max_missing, remove_surface(1));
        CHECK(next_of(victim.link).header().sequence() == 4 + max_missing);
    }

    TEST_CASE("times too far ahead are refused and not adopted") {
        Victim victim;
        ZmqLink receiver({2, Role::renderer}, ipc_address("receiver-of-times"));
        receiver.add_peer(gp_id, Role::gp, victim.link.endpoint());
        victim.link.add_peer(2, Role::renderer, receiver.endpoint());
        victim.link.add_peer(3, Role::gp, ipc_address("liar"));
        RawPeer liar(victim.link.endpoint());
        schema::BeginFrameT begin;
        begin.draw = std::make_unique<schema::DrawFrameT>(test::example_draw());
        begin.assignment = {0, 0, 0, 0, 0, 0};
        const auto refused = [&](std::uint64_t number, std::uint64_t arrival_ns,
                                 std::uint64_t clock) {
            liar.send_as(3, gp_id, number, pack(begin), arrival_ns, clock);
            CHECK_THROWS_AS(next_of(victim.link), WireFault);
        };
        refused(0, ~std::uint64_t{0}, 1);
        refused(1, max_ahead_ns + 1, 1);
        refused(2, 0, ~std::uint64_t{0});
        liar.send_as(3, gp_id, 3, pack(begin), max_ahead_ns / 2, 1);
        CHECK(next_of(victim.link).kind() == Body::BeginFrame);
        victim.host.send_as(host_id, gp_id, 0, remove_surface(1), last_time_ns + 1);
        CHECK_THROWS_AS(next_of(victim.link), WireFault);
        victim.link.send(2, pack(begin));
        const Message answer = next_of(receiver);
        CHECK(answer.header().arrival_ns() < max_ahead_ns);
        CHECK(answer.header().clock() < 10);
    }

    TEST_CASE("a Hello without the secret is dropped, and the true child can still say Hello") {
        Host host;
        std::vector<Refusal> named;
        host.link.on_refusal([&](const Refusal& refusal) { named.push_back(refusal); });
        schema::HelloT wrong = Host::hello();
        host.gp.send_as(gp_id, host_id, 0, pack(wrong));
        wrong.secret = std::make_unique<schema::Secret>(1, 2);
        host.gp.send_as(gp_id, host_id, 0, pack(wrong));
        host.gp.send_as(gp_id, host_id, 0, pack(schema::ConnectedT{}));
        await_refusals(host.link, 3);
        Payload damaged = host.true_hello();
        schema::Header header(header_magic, protocol_version,
                              static_cast<std::uint16_t>(Body::Hello), gp_id, host_id, 0, 0, 0,
                              damaged.bytes().size() + 1, 0, 0, 1);
        host.gp.send(header, damaged);
        await_refusals(host.link, 4);
        host.gp.send_as(gp_id, host_id, 0, host.true_hello());
        const Message hello = next_of(host.link);
        REQUIRE(hello.kind() == Body::Hello);
        // The host records the message, but not the secret.
        REQUIRE(hello.as<schema::Hello>()->secret() != nullptr);
        CHECK(hello.as<schema::Hello>()->secret()->low() == 0);
        CHECK(hello.as<schema::Hello>()->secret()->high() == 0);
        CHECK(hello.as<schema::Hello>()->build()->str() == "b");
        host.gp.send_as(gp_id, host_id, 1, pack(schema::ConnectedT{}));
        CHECK(next_of(host.link).kind() == Body::Connected);
        host.gp.send_as(gp_id, host_id, 2, host.true_hello());
        await_refusals(host.link, 5);
        host.gp.send_as(gp_id, host_id, 2, pack(schema::VolumeReadyT{}));
        CHECK(next_of(host.link).kind() == Body::VolumeReady);
        REQUIRE(named.size() == 4);
        CHECK(contains(named[0].text, "Hello from node 1, without the secret of this machine"));
        CHECK(contains(named[3].text, "Hello from node 1, which a node of role gp may not send"));
    }

    TEST_CASE("a message on the socket for io processes counts for no other node") {
        ZmqLink host({host_id, Role::host}, ipc_address("two-sockets"));
        const std::string apart = host.listen_apart(Role::io, ipc_address("for-io"));
        constexpr NodeId io_id = 9;
        host.add_peer(gp_id, Role::gp, ipc_address("beside-io"));
        host.add_peer(io_id, Role::io, ipc_address("io"));
        std::vector<Refusal> named;
        host.on_refusal([&](const Refusal& refusal) { named.push_back(refusal); });
        RawPeer gp(host.endpoint()), io(apart);
        io.send_as(gp_id, host_id, 0, pack(schema::VolumeReadyT{}));
        await_refusals(host, 1);
        gp.send_as(io_id, host_id, 0, pack(schema::IoDoneT{}));
        await_refusals(host, 2);
        REQUIRE(named.size() == 1);
        CHECK(named[0].text == "VolumeReady from node 1, on the socket for nodes of role io");
        // The numbers of both nodes are still due.
        io.send_as(io_id, host_id, 0, pack(schema::IoDoneT{}));
        CHECK(next_of(host).kind() == Body::IoDone);
        gp.send_as(gp_id, host_id, 0, pack(schema::VolumeReadyT{}));
        CHECK(next_of(host).kind() == Body::VolumeReady);
    }

    TEST_CASE("the host's times do not follow those of an io process") {
        ZmqLink host({host_id, Role::host}, ipc_address("timeless"));
        const std::string apart = host.listen_apart(Role::io, ipc_address("timeless-io"));
        constexpr NodeId io_id = 9;
        ZmqLink receiver({gp_id, Role::gp}, ipc_address("receiver-of-the-host"));
        receiver.add_peer(host_id, Role::host, host.endpoint());
        host.add_peer(gp_id, Role::gp, receiver.endpoint());
        host.add_peer(io_id, Role::io, ipc_address("liar-io"));
        RawPeer io(apart);
        for (std::uint64_t number = 0; number < 3; ++number) {
            io.send_as(io_id, host_id, number, pack(schema::IoDoneT{}),
                       (number + 1) * max_ahead_ns / 4, last_clock);
            CHECK(next_of(host).kind() == Body::IoDone);
        }
        host.send(gp_id, remove_surface(1));
        const Message order = next_of(receiver);
        CHECK(order.header().arrival_ns() < max_ahead_ns / 4);
        CHECK(order.header().clock() < 10);
    }

    TEST_CASE("the descriptor of a link with two sockets is readable for each of them") {
        ZmqLink host({host_id, Role::host}, ipc_address("watched"));
        const std::string apart = host.listen_apart(Role::io, ipc_address("watched-io"));
        constexpr NodeId io_id = 9;
        host.add_peer(gp_id, Role::gp, ipc_address("watched-gp"));
        host.add_peer(io_id, Role::io, ipc_address("watched-sender"));
        RawPeer gp(host.endpoint()), io(apart);
        constexpr int patience_ms = 30000;
        const auto await = [&](Body kind) {
            std::optional<Message> message;
            while (!(message = host.receive())) {  // Empties both sockets before each wait.
                pollfd entry{host.poll_fd(), POLLIN, 0};
                REQUIRE(poll(&entry, 1, patience_ms) == 1);
            }
            CHECK(message->kind() == kind);
        };
        for (std::uint64_t number = 0; number < 20; ++number) {
            io.send_as(io_id, host_id, number, pack(schema::IoDoneT{}));
            await(Body::IoDone);
            gp.send_as(gp_id, host_id, number, pack(schema::VolumeReadyT{}));
            await(Body::VolumeReady);
        }
        while (host.receive()) {
        }
        pollfd entry{host.poll_fd(), POLLIN, 0};
        CHECK(poll(&entry, 1, 0) == 0);  // Else the host would not sleep.
    }

    TEST_CASE("the second socket has its turn when the first is empty, or after a change") {
        zmq::context_t context;
        Inbound inbound(context);
        inbound.open_apart();
        RawPeer common(inbound.bind(Entrance::common, ipc_address("turns"))),
            apart(inbound.bind(Entrance::apart, ipc_address("turns-io")));
        const auto arrive = [&](RawPeer& peer, Entrance entrance) {
            peer.socket().send(zmq::buffer("x", 1));
            constexpr std::chrono::milliseconds patience(30000);
            zmq::pollitem_t item{inbound.socket(entrance).handle(), 0, ZMQ_POLLIN, 0};
            REQUIRE(zmq::poll(&item, 1, patience) == 1);
        };
        for (int round = 0; round < 2; ++round) {
            arrive(apart, Entrance::apart);
            arrive(common, Entrance::common);
            zmq::message_t head;
            CHECK(inbound.take(head) == Entrance::common);
            arrive(common, Entrance::common);
            inbound.change_turns();  // A flood at the first socket.
            CHECK(inbound.take(head) == Entrance::apart);
            CHECK(inbound.take(head) == Entrance::common);
            CHECK(!inbound.take(head));
        }
    }

    TEST_CASE("an arena is opened only for nodes that share memory, and never for the io process") {
        for (const Role role : {Role::host, Role::io}) {
            CAPTURE(schema::EnumNameRole(role));
            // Both roles may send slices: a host to a GP, an io process to a host.
            const bool shares = role == Role::host;
            ZmqLink link({2, shares ? Role::gp : Role::host}, ipc_address("offered"));
            link.add_peer(1, role, ipc_address("offering"));
            RawPeer peer(link.endpoint());
            Arena arena;
            Wire wire(1);
            const Payload payload = test::large_slices(&arena, 100'000, 1);
            const schema::Header header =
                wire.header_for(2, payload.kind(), payload.bytes().size());
            const ArenaOffer offer = arena.offer();
            std::vector<std::uint8_t> head(sizeof header + sizeof offer);
            std::memcpy(head.data(), &header, sizeof header);
            std::memcpy(head.data() + sizeof header, &offer, sizeof offer);
            peer.socket().send(zmq::buffer(head), zmq::send_flags::sndmore);
            peer.socket().send(zmq::buffer(payload.bytes().data(), payload.bytes().size()));
            CHECK(test::is_whole(next_of(link), 100'000, 1));
            CHECK(arena.lend(2, payload).has_value() == shares);
        }
    }

    TEST_CASE("a body that is too large for a message takes no credit of its receiver") {
        ZmqLink sender({host_id, Role::host}, ipc_address("too-much"));
        ZmqLink receiver({gp_id, Role::gp}, ipc_address("too-little"));
        sender.add_peer(gp_id, Role::gp, receiver.endpoint());
        receiver.add_peer(host_id, Role::host, sender.endpoint());
        {
            flatbuffers::FlatBufferBuilder builder(max_body_bytes + 1024);
            std::uint8_t* values = nullptr;  // Never written, so that they take no memory.
            const auto at = builder.CreateUninitializedVector(max_body_bytes, &values);
            const Payload huge = finish(builder, schema::CreateSlices(builder, 0, 0, 1, at));
            CHECK_THROWS_AS(sender.send(gp_id, huge), NodeFault);
        }
        CHECK(sender.queued() == 0);
        sender.send(gp_id, remove_surface(3));
        CHECK(next_of(receiver).as<schema::RemoveSurface>()->surface() == 3);
    }
}
