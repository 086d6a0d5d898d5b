#include <doctest/doctest.h>
#include <unistd.h>

#include <filesystem>
#include <thread>
#include <zmq.hpp>

#include "ringbus/credit.hpp"
#include "ringbus/node_loop.hpp"
#include "ringbus/process.hpp"
#include "ringbus/zmq_link.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5::bus;
using pxpl5::test::contains;

namespace {

constexpr int patience_ms = 30000;

std::string ipc_address(const char* name) {
    return "ipc://" + (std::filesystem::temp_directory_path() /
                       ("pxpl5-" + std::to_string(getpid()) + "-" + name))
                          .string();
}

/// Two links that know each other.
struct Pair {
    ZmqLink a, b;
    Pair(const std::string& bind_a, const std::string& bind_b) : a(1, bind_a), b(2, bind_b) {
        a.add_peer(2, b.endpoint());
        b.add_peer(1, a.endpoint());
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

TEST_SUITE("ringbus/zmq_link") {
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
        ZmqLink early(1, ipc_address("early"));
        const std::string address = ipc_address("late");
        early.add_peer(2, address);
        early.send(2, slices(100, 7));
        ZmqLink late(2, address);
        CHECK(next(late).as<schema::Slices>()->first_slice() == 7);
    }

    TEST_CASE("addresses that others could reach are refused") {
        CHECK_THROWS_AS(ZmqLink(1, "tcp://0.0.0.0:*"), std::invalid_argument);
        CHECK_THROWS_AS(ZmqLink(1, "tcp://*:5555"), std::invalid_argument);
        CHECK_THROWS_AS(ZmqLink(1, "ipc:///no/such/folder/socket"), std::runtime_error);
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

    TEST_CASE("large bodies are bounded by bytes in flight, and one alone may exceed the window") {
        Window window;
        CHECK(window.has_room(window_bytes * 2));
        window.take(window_bytes * 2);
        CHECK(!window.has_room(1));
        CHECK(window.give_back(1, window_bytes * 2));
        window.take(window_bytes / 2);
        CHECK(window.has_room(window_bytes / 2));
        CHECK(!window.has_room(window_bytes / 2 + 1));
        CHECK(!window.give_back(2, 1));
    }

    TEST_CASE("two nodes that flood each other both get everything") {
        Pair pair = ipc_pair();
        const std::uint32_t count = 2 * window_messages;
        const auto flood = [count](ZmqLink& link, NodeId to) {
            for (std::uint32_t i = 0; i < count; ++i) {
                link.send(to, slices(1000, i % 4096));
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
        std::thread other([&] { got_b = flood(pair.b, 1); });
        const std::uint32_t got_a = flood(pair.a, 2);
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
        ZmqLink link(2, ipc_address("gap"));
        zmq::context_t context(1);
        zmq::socket_t socket(context, zmq::socket_type::push);
        socket.set(zmq::sockopt::linger, 0);
        socket.connect(link.endpoint());
        const Payload payload = slices(10, 1);
        for (const std::uint64_t sequence : {0U, 2U, 3U}) {
            const schema::Header header(header_magic, protocol_version,
                                        static_cast<std::uint16_t>(payload.kind()), 1, 2, 0, 0,
                                        sequence, payload.bytes().size(), 0, 0);
            socket.send(zmq::buffer(&header, sizeof header), zmq::send_flags::sndmore);
            socket.send(zmq::buffer(payload.bytes().data(), payload.bytes().size()));
        }
        CHECK(next(link).header().sequence() == 0);
        while (!link.wait(patience_ms)) {
        }
        CHECK_THROWS_WITH_AS(next(link), "message 2 from node 1 came where 1 was due", NodeFault);
        CHECK(next(link).header().sequence() == 3);
    }

    TEST_CASE("bytes that are no message are refused, and the next message still comes") {
        ZmqLink link(2, ipc_address("junk"));
        zmq::context_t context(1);
        zmq::socket_t socket(context, zmq::socket_type::push);
        socket.set(zmq::sockopt::linger, 0);
        socket.connect(link.endpoint());
        socket.send(zmq::str_buffer("junk"));
        socket.send(zmq::str_buffer("a"), zmq::send_flags::sndmore);
        socket.send(zmq::str_buffer("b"), zmq::send_flags::sndmore);
        socket.send(zmq::str_buffer("c"));
        ZmqLink sender(1, ipc_address("sender"));
        CHECK_THROWS_AS(next(link), BadMessage);
        CHECK_THROWS_AS(next(link), BadMessage);
        sender.add_peer(2, link.endpoint());
        sender.send(2, slices(10, 1));
        CHECK(next(link).as<schema::Slices>()->first_slice() == 1);
    }
}

TEST_SUITE("ringbus/process") {
    TEST_CASE("flags survive the command line") {
        const ProcessFlags flags{"ipc://h", "ipc://b", 7, 3, 4242};
        std::vector<std::string> words = to_arguments(flags);
        words.insert(words.begin(), "program");
        words.emplace_back("--memory-mib");  // For the program's own main.
        words.emplace_back("5");
        std::vector<char*> argv;
        for (std::string& word : words) {
            argv.push_back(word.data());
        }
        const ProcessFlags back = parse_flags(static_cast<int>(argv.size()), argv.data());
        CHECK(back.host_endpoint == flags.host_endpoint);
        CHECK(back.bind == flags.bind);
        CHECK(back.node_id == 7);
        CHECK(back.index == 3);
        CHECK(back.parent_pid == 4242);
    }

    TEST_CASE("missing and malformed flags are named") {
        const auto error = [](std::vector<std::string> words) {
            words.insert(words.begin(), "program");
            std::vector<char*> argv;
            for (std::string& word : words) {
                argv.push_back(word.data());
            }
            try {
                parse_flags(static_cast<int>(argv.size()), argv.data());
            } catch (const std::invalid_argument& bad) {
                return std::string(bad.what());
            }
            return std::string();
        };
        CHECK(contains(error({}), "--host-endpoint"));
        CHECK(contains(error({"--node-id"}), "--node-id needs a value"));
        CHECK(contains(error({"--node-id", "0"}), "--node-id is '0'"));
        CHECK(contains(error({"--index", "x"}), "--index is 'x'"));
    }

    TEST_CASE("a child of another build or schema is refused with both values") {
        const auto answer = [](const std::string& build, std::uint64_t hash) {
            schema::HelloT hello;
            hello.endpoint = "ipc://x";
            hello.build = build;
            hello.schema_hash = hash;
            const Payload payload = pack(hello);
            return refuse_hello(*schema::GetMessage(payload.bytes().data())->body_as_Hello());
        };
        CHECK(answer(build_id(), schema_hash()).empty());
        CHECK(contains(answer("pxpl5 0.0.9", schema_hash()), "pxpl5 0.0.9"));
        CHECK(contains(answer(build_id(), 1), "0000000000000001"));
    }
}
