#include <doctest/doctest.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <thread>
#include <zmq.hpp>

#include "ringbus/credit.hpp"
#include "ringbus/wire.hpp"
#include "ringbus/zmq/zmq_link.hpp"
#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/ipc_address.hpp"
#include "tests/ringbus/test_zmq_link_peer.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::contains;
using pxpl5::test::ipc_address;

namespace {

constexpr int patience_ms = 30000;

using schema::Role;
constexpr Self host_1{1, Role::host}, gp_2{2, Role::gp};

Credentials plain_tcp() {
    Credentials credentials;
    credentials.allows_plain_tcp = true;
    return credentials;
}

/// Two links that know each other: a host and a GP.
struct Pair {
    ZmqLink a, b;
    Pair(const std::string& bind_a, const std::string& bind_b)
        : a(host_1, bind_a, plain_tcp()), b(gp_2, bind_b, plain_tcp()) {
        a.add_peer(2, Role::gp, b.endpoint());
        b.add_peer(1, Role::host, a.endpoint());
    }
};

Pair ipc_pair() {
    return Pair(ipc_address("a"), ipc_address("b"));
}

Message next(ZmqLink& link) {
    while (true) {
        if (auto message = link.receive()) {
            return *message;
        }
        REQUIRE(link.wait(patience_ms));
    }
}

Payload slices(std::size_t bytes, std::uint32_t number) {
    schema::SlicesT body;
    body.slice_count = 1;
    body.first_slice = number;
    body.values.assign(bytes, static_cast<std::uint8_t>(number));
    return pack(body);
}

}  // namespace

TEST_SUITE("ringbus/zmq/zmq_link") {
    TEST_CASE("messages arrive whole and in order over ipc and over tcp") {
        for (const bool tcp : {false, true}) {
            Pair pair = tcp ? Pair("tcp://127.0.0.1:*", "tcp://127.0.0.1:*") : ipc_pair();
            for (std::uint32_t i = 0; i < 200; ++i) {
                pair.a.send(2, slices(1 + i * 37, i));
            }
            for (std::uint32_t i = 0; i < 200; ++i) {
                const Message message = next(pair.b);
                const auto* body = message.as<schema::Slices>();
                REQUIRE(body != nullptr);
                CHECK(body->first_slice() == i);
                CHECK(body->values()->size() == 1 + i * 37);
                CHECK(body->values()->Get(i * 37) == static_cast<std::uint8_t>(i));
                CHECK(reinterpret_cast<std::uintptr_t>(message.bytes().data()) % 8 == 0);
            }
        }
    }

    TEST_CASE("a message sent before its receiver listens is not lost") {
        ZmqLink early(host_1, ipc_address("early"));
        const std::string address = ipc_address("late");
        early.add_peer(2, Role::gp, address);
        early.send(2, slices(100, 7));
        ZmqLink late(gp_2, address);
        late.add_peer(1, Role::host, early.endpoint());
        CHECK(next(late).as<schema::Slices>()->first_slice() == 7);
    }

    TEST_CASE("addresses outside this computer are refused") {
        for (const std::string address :
             {"tcp://0.0.0.0:*", "tcp://*:5555", "ipc://@name", "inproc://x", ""}) {
            const std::string reason =
                ": only ipc:///path and tcp://127.0.0.1:port are private to this computer";
            CHECK_THROWS_WITH_AS(ZmqLink(host_1, address, plain_tcp()),
                                 ("refusing to listen at " + address + reason).c_str(),
                                 std::invalid_argument);
            ZmqLink link(host_1, ipc_address("private"), plain_tcp());
            CHECK_THROWS_WITH_AS(link.add_peer(2, Role::gp, address),
                                 ("refusing to connect to " + address + reason).c_str(),
                                 std::invalid_argument);
        }
        CHECK_THROWS_AS(ZmqLink(host_1, "ipc:///no/such/folder/socket"), std::runtime_error);
    }

    TEST_CASE("a sender without credit keeps its messages and never blocks") {
        Pair pair = ipc_pair();
        const std::uint32_t count = 3 * window_messages;
        for (std::uint32_t i = 0; i < count; ++i) {
            pair.a.send(2, slices(10, i % 4096));
        }
        CHECK(pair.a.queued() == count - window_messages);
        for (std::uint32_t i = 0; i < count; ++i) {
            while (true) {
                // The sender's own input brings the credit.
                CHECK(!pair.a.receive());
                if (const auto message = pair.b.receive()) {
                    REQUIRE(message->as<schema::Slices>()->first_slice() == i % 4096);
                    break;
                }
                if (!pair.b.wait(1)) {
                    pair.a.wait(1);
                }
            }
        }
        CHECK(pair.a.queued() == 0);
    }

    TEST_CASE("two nodes that flood each other both get everything") {
        Pair pair = ipc_pair();
        const std::uint32_t count = 2 * window_messages;
        const auto flood = [count](ZmqLink& link, NodeId to, const Payload& payload) {
            for (std::uint32_t i = 0; i < count; ++i) {
                link.send(to, payload);
            }
            std::uint32_t got = 0;
            while (got < count || link.queued() > 0) {
                if (link.receive()) {
                    ++got;
                } else if (!link.wait(patience_ms)) {
                    break;
                }
            }
            return got;
        };
        std::uint32_t got_b = 0;
        std::thread other([&] { got_b = flood(pair.b, 1, pack(schema::VolumeReadyT{})); });
        const std::uint32_t got_a = flood(pair.a, 2, slices(1000, 1));
        // The other side may still wait for credit, which comes only while this side receives.
        std::atomic<bool> joined{false};
        std::thread pump([&] {
            while (!joined) {
                pair.a.receive();
                pair.a.wait(10);
            }
        });
        other.join();
        joined = true;
        pump.join();
        CHECK(got_a == count);
        CHECK(got_b == count);
    }

    TEST_CASE("a gap in a sender's numbers is a named fault, and the next message still comes") {
        ZmqLink link(gp_2, ipc_address("gap"));
        link.add_peer(1, Role::host, ipc_address("gap-1"));
        zmq::context_t context(1);
        zmq::socket_t socket(context, zmq::socket_type::push);
        socket.set(zmq::sockopt::linger, 0);
        socket.connect(link.endpoint());
        const Payload payload = slices(10, 1);
        for (const std::uint64_t sequence : {0U, 2U, 3U}) {
            const schema::Header header(header_magic, protocol_version,
                                        static_cast<std::uint16_t>(payload.kind()), 1, 2, 0, 0,
                                        sequence, payload.bytes().size(), 0, 0, sequence);
            socket.send(zmq::buffer(&header, sizeof header), zmq::send_flags::sndmore);
            socket.send(zmq::buffer(payload.bytes().data(), payload.bytes().size()));
        }
        CHECK(next(link).header().sequence() == 0);
        while (!link.wait(patience_ms)) {
        }
        CHECK_THROWS_WITH_AS(next(link), "message 2 from node 1 came where 1 was due", NodeFault);
        CHECK(next(link).header().sequence() == 3);
    }

    TEST_CASE("bytes that are no message are dropped and counted, and the next message comes") {
        ZmqLink link(gp_2, ipc_address("junk"));
        std::vector<std::string> named;
        link.on_refusal([&](const Refusal& refusal) { named.push_back(refusal.text); });
        zmq::context_t context(1);
        zmq::socket_t socket(context, zmq::socket_type::push);
        socket.set(zmq::sockopt::linger, 0);
        socket.connect(link.endpoint());
        socket.send(zmq::str_buffer("junk"));
        socket.send(zmq::str_buffer("a"), zmq::send_flags::sndmore);
        socket.send(zmq::str_buffer("b"), zmq::send_flags::sndmore);
        socket.send(zmq::str_buffer("c"));
        test::await_refusals(link, 2);
        REQUIRE(named.size() == 1);  // Once for each reason.
        CHECK(contains(named[0], "a message of 1 parts with a header of 4 bytes, expected 2"));
        ZmqLink sender(host_1, ipc_address("sender"));
        link.add_peer(1, Role::host, sender.endpoint());
        sender.add_peer(2, Role::gp, link.endpoint());
        sender.send(2, slices(10, 1));
        CHECK(next(link).as<schema::Slices>()->first_slice() == 1);
    }

    TEST_CASE("refused messages give their credit back") {
        Pair pair = ipc_pair();
        schema::VolumeHeaderT header = pxpl5::test::example_header();
        header.nz = 0;
        const Payload refused = pack(header);
        const std::uint32_t count = 2 * window_messages;
        for (std::uint32_t i = 0; i < count; ++i) {
            pair.a.send(2, refused);
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            CHECK(!pair.a.receive());  // Takes the credit.
            CHECK_THROWS_AS(next(pair.b), BadMessage);
            if (i + 1 == window_messages) {
                REQUIRE(pair.a.wait(patience_ms));
            }
        }
        CHECK(!pair.a.receive());
        CHECK(pair.a.queued() == 0);
    }

    TEST_CASE("credit for messages that were never sent is refused") {
        Pair pair = ipc_pair();
        schema::CreditT credit;
        credit.messages = 1;
        pair.b.send(1, pack(credit));
        CHECK_THROWS_WITH_AS(next(pair.a),
                             "node 2 gives back 1 messages and 0 bytes, more than it was sent",
                             WireFault);
    }

    TEST_CASE("a full queue for a receiver without credit is a named fault") {
        Pair pair = ipc_pair();
        const Payload payload = slices(10, 1);
        for (std::size_t i = 0; i < window_messages + max_waiting_messages; ++i) {
            pair.a.send(2, payload);
        }
        try {
            pair.a.send(2, payload);
            FAIL("accepted");
        } catch (const NodeFault& fault) {
            CHECK(fault.code == schema::FaultCode::out_of_memory);
            CHECK(contains(fault.what(), "node 2 takes nothing: 1048576 messages of"));
        }
        CHECK(pair.a.queued() == max_waiting_messages);
    }

    TEST_CASE("messages for a removed peer are dropped") {
        Pair pair = ipc_pair();
        const Payload payload = slices(10, 1);
        for (std::size_t i = 0; i < window_messages + 5; ++i) {
            pair.a.send(2, payload);
        }
        CHECK(pair.a.queued() == 5);
        pair.a.remove_peer(2);
        CHECK(pair.a.queued() == 0);
    }

    TEST_CASE("a peer without messages costs no socket") {
        const auto open_files = [] {
            return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
        };
        ZmqLink link(host_1, ipc_address("quiet")), other(gp_2, ipc_address("heard"));
        other.add_peer(1, Role::host, link.endpoint());
        const auto before = open_files();
        for (NodeId id = 3; id < 53; ++id) {
            link.add_peer(id, Role::gp, ipc_address("never"));
        }
        CHECK(open_files() == before);
        link.add_peer(2, Role::gp, other.endpoint());
        link.send(2, slices(10, 1));
        CHECK(next(other).as<schema::Slices>()->first_slice() == 1);
        CHECK(open_files() > before);
    }

    TEST_CASE("the last messages still leave when the link is destroyed, with a linger time") {
        ZmqLink receiver(gp_2, ipc_address("receiver"));
        receiver.add_peer(1, Role::host, ipc_address("leaver"));
        const std::uint32_t count = 12;  // Within the window, and far more than a socket holds.
        {
            ZmqLink sender(host_1, ipc_address("leaver"));
            sender.add_peer(2, Role::gp, receiver.endpoint());
            sender.linger(2, patience_ms);
            for (std::uint32_t i = 0; i < count; ++i) {
                sender.send(2, slices(1 << 20, i));
            }
        }
        for (std::uint32_t i = 0; i < count; ++i) {
            CHECK(next(receiver).as<schema::Slices>()->first_slice() == i);
        }
    }

    TEST_CASE("signals between two messages are harmless") {
        static std::atomic<int> signals;
        signals = 0;
        struct sigaction action {};
        action.sa_handler = [](int) { ++signals; };  // Without SA_RESTART.
        struct sigaction before {};
        sigaction(SIGUSR1, &action, &before);
        const pthread_t self = pthread_self();
        Pair pair = ipc_pair();
        std::atomic<bool> over{false};
        std::thread disturber([&] {
            while (!over) {
                const int seen = signals;
                pthread_kill(self, SIGUSR1);
                while (!over && signals == seen) {
                    std::this_thread::yield();
                }
            }
        });
        std::uint32_t good = 0, sent = 0;
        while (sent < 2000 || signals < 200) {
            pair.a.send(2, slices(100, sent % 4096));
            good += pair.a.receive() ? 0U : 1U;  // Only credit comes, which is not shown.
            while (true) {
                if (const auto message = pair.b.receive()) {
                    good += message->as<schema::Slices>()->first_slice() == sent % 4096 ? 1U : 0U;
                    break;
                }
                pair.b.wait(patience_ms);
            }
            ++sent;
        }
        over = true;
        disturber.join();
        sigaction(SIGUSR1, &before, nullptr);
        CHECK(good == 2 * sent);
    }
}
