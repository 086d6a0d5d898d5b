#include <doctest/doctest.h>

#include <memory>
#include <set>

#include "ringbus/simulated/simulated_link.hpp"

using namespace pxpl5::bus;

namespace {

/// Remembers received messages.
struct Recorder final : Node {
    std::vector<std::pair<NodeId, std::uint32_t>> got;
    std::vector<std::string> faults;
    std::uint64_t arrival_ns = 0;  ///< Arrival of the last message.

    void receive(const Message& message, Outbox&) override {
        arrival_ns = message.header().arrival_ns();
        if (const auto* surface = message.as<schema::RemoveSurface>()) {
            got.emplace_back(message.source(), surface->surface());
        } else if (const auto* fault = message.as<schema::Fault>()) {
            faults.push_back(fault->reason()->str());
        }
    }
    bool work(Outbox&) override { return false; }
};

/// Throws at every message.
struct Thrower final : Node {
    void receive(const Message&, Outbox&) override {
        throw NodeFault(schema::FaultCode::bad_input, "not today");
    }
    bool work(Outbox&) override { return false; }
};

Payload numbered(std::uint16_t number) {
    schema::RemoveSurfaceT body;
    body.surface = number;
    return pack(body);
}

struct Trio {
    SimulatedRing ring;
    Recorder host, a, b;
    explicit Trio(std::uint64_t seed, SimulatedFault fault = {}) : ring(seed, fault) {
        ring.add(0, host);
        ring.add(1, a);
        ring.add(2, b);
        for (std::uint16_t i = 0; i < 10; ++i) {
            ring.send(1, 0, numbered(i));
            ring.send(2, 0, numbered(i));
        }
    }
};

}  // namespace

TEST_SUITE("ringbus/simulated_ring") {
    TEST_CASE("the order between two nodes is kept whatever the seed") {
        for (std::uint64_t seed = 0; seed < 50; ++seed) {
            Trio trio(seed);
            trio.ring.run_until_idle();
            REQUIRE(trio.host.got.size() == 20);
            std::uint32_t next[3] = {0, 0, 0};
            for (const auto& [source, number] : trio.host.got) {
                CHECK(number == next[source]++);
            }
        }
    }

    TEST_CASE("the order between senders depends on the seed, and on nothing else") {
        std::set<std::vector<std::pair<NodeId, std::uint32_t>>> orders;
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            Trio first(seed), again(seed);
            first.ring.run_until_idle();
            again.ring.run_until_idle();
            CHECK(first.host.got == again.host.got);
            orders.insert(first.host.got);
        }
        CHECK(orders.size() > 15);
    }

    TEST_CASE("each kind of damage to a message is detected and named") {
        for (const auto& [damage, text] :
             {std::pair{Damage::drop, "message 3 from node 1 came where 2 was due"},
              std::pair{Damage::repeat, "message 2 from node 1 came where 3 was due"},
              std::pair{Damage::flip_bit, "RemoveSurface 2 from node 1: its"},
              std::pair{Damage::flip_header_bit, "from node"}}) {
            for (std::uint64_t seed = 0; seed < 200; ++seed) {
                CAPTURE(seed);
                CAPTURE(text);
                Trio trio(seed, {damage, 4});  // The third from node 1.
                trio.ring.run_until_idle();
                REQUIRE(!trio.host.faults.empty());
                CHECK(trio.host.faults[0].find(text) != std::string::npos);
                CHECK(trio.host.got.size() >= 17);
            }
        }
        Trio sound(3);
        sound.ring.run_until_idle();
        CHECK(sound.host.faults.empty());
    }

    TEST_CASE("stamps come from the ring's model") {
        Trio trio(1);
        // One nanosecond per byte and one second per hop: only the hops matter.
        trio.ring.set_model(ChannelModel({8, 1'000'000'000, 1'000'000'000, 2, 4}, {0, 1, 2}));
        trio.ring.send(0, 2, numbered(1));
        trio.ring.run_until_idle();
        CHECK(trio.b.arrival_ns / 1'000'000'000 == 2);
    }

    TEST_CASE("a tap receives each message before the node, in order") {
        Trio trio(5);
        std::vector<std::pair<NodeId, std::uint32_t>> seen;
        trio.ring.on_delivery([&](NodeId to, const Message& message) {
            CHECK(to == host_id);
            CHECK(trio.host.got.size() == seen.size());
            seen.emplace_back(message.source(), message.as<schema::RemoveSurface>()->surface());
        });
        trio.ring.run_until_idle();
        CHECK(seen.size() == 20);
        CHECK(seen == trio.host.got);
    }

    TEST_CASE("an exception of a node reaches the host as a Fault") {
        SimulatedRing ring(1);
        Recorder host;
        Thrower thrower;
        ring.add(0, host);
        ring.add(1, thrower);
        ring.send(0, 1, numbered(1));
        ring.run_until_idle();
        CHECK(host.faults == std::vector<std::string>{"not today"});
    }

    TEST_CASE("a message that no rule allows between two roles is dropped and counted") {
        SimulatedRing ring(1);
        Recorder host, renderer;
        ring.add(0, host, schema::Role::host);
        ring.add(1, renderer, schema::Role::renderer);
        ring.send(0, 1, numbered(1));  // For GPs only.
        ring.send(1, 0, pack(schema::ShutdownT{}));
        ring.run_until_idle();
        CHECK(renderer.got.empty());
        CHECK(host.faults.empty());
        CHECK(ring.traffic(0).refused_messages == 1);
        CHECK(ring.traffic(1).refused_messages == 1);
        CHECK(ring.traffic(1).received_messages == 0);
    }

    TEST_CASE("waiting for an impossible state is an error") {
        SimulatedRing ring(1);
        Recorder host;
        ring.add(0, host);
        CHECK_THROWS_AS(ring.run_until([] { return false; }), SimulationStuck);
    }
}
