#include <doctest/doctest.h>

#include <string>

#include "host/machine/handshake.hpp"
#include "host/machine/port.hpp"

using namespace pxpl5;
using namespace pxpl5::host;
namespace schema = bus::schema;

namespace {

Topology two_by_one() {
    Topology topology;
    topology.gp.count = 2;
    topology.renderer.count = 1;
    topology.frame_buffer.count = 1;
    return topology;
}

/// The roster of two_by_one() without the host, as processes 101, 102, ...
Roster started() {
    Roster roster = roster_of(two_by_one());
    roster.erase(roster.begin());
    int pid = 101;
    for (RosterEntry& node : roster) {
        node.pid = pid++;
    }
    return roster;
}

schema::HelloT hello_of(schema::Role role, int index, int pid) {
    schema::HelloT hello;
    hello.role = role;
    hello.index = static_cast<std::uint16_t>(index);
    hello.pid = static_cast<std::uint32_t>(pid);
    hello.endpoint = "ipc:///run/x";
    hello.build = "build-1";
    hello.schema_hash = 0xabc;
    return hello;
}

/// Says Hello as the node of this process, as the launcher has numbered it.
void say(Handshake& handshake, const schema::HelloT& hello, bus::NodeId id = 2) {
    const bus::Payload payload = bus::pack(hello);
    handshake.hello(id, *schema::GetMessage(payload.bytes().data())->body_as_Hello());
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("the ring's order is host, GPs, Renderers, frame buffer, and ids count up along it") {
    const Roster roster = roster_of(two_by_one());
    Names names;
    for (const RosterEntry& node : roster) {
        CHECK(node.id == names.size());
        names.push_back(node.name());
    }
    CHECK(names == Names{"host", "gp-0", "gp-1", "renderer-0", "framebuffer-0"});
    CHECK(ids_of(roster, schema::Role::gp) == std::vector<bus::NodeId>{1, 2});
    CHECK(ids_of(roster, schema::Role::renderer) == std::vector<bus::NodeId>{3});
}

TEST_CASE("a node is told the whole ring and its model's numbers") {
    Topology plan = two_by_one();
    plan.gp_memory_mib = 8;
    plan.ring = {7, Transport::tcp, 80, 50};
    Roster roster = roster_of(plan);
    for (RosterEntry& node : roster) {
        node.endpoint = "tcp://127.0.0.1:" + std::to_string(1000 + node.id);
    }
    const bus::Payload payload = topology_message(roster, plan);
    const auto& told = *schema::GetMessage(payload.bytes().data())->body_as_Topology();
    REQUIRE(told.nodes()->size() == 5);
    CHECK(told.nodes()->Get(2)->endpoint()->str() == "tcp://127.0.0.1:1002");
    CHECK(told.nodes()->Get(2)->role() == schema::Role::gp);
    CHECK(told.nodes()->Get(2)->index() == 1);
    CHECK(told.gp_memory_bytes() == 8U * 1024 * 1024);
    CHECK(told.ring_channels() == 7);
    CHECK(told.ring_bytes_per_s() == 80'000'000);
    CHECK(told.ring_hop_ns() == 50);
}

TEST_CASE("the handshake knows who is missing") {
    Handshake handshake(started(), {"build-1", 0xabc});
    CHECK(handshake.without_hello() == Names{"gp-0", "gp-1", "renderer-0", "framebuffer-0"});
    say(handshake, hello_of(schema::Role::frame_buffer, 0, 104), 4);
    say(handshake, hello_of(schema::Role::gp, 1, 102));
    CHECK(handshake.without_hello() == Names{"gp-0", "renderer-0"});
    CHECK(handshake.nodes()[1].endpoint == "ipc:///run/x");
    handshake.connected(4);
    handshake.connected(1);
    CHECK(handshake.unconnected() == Names{"gp-1", "renderer-0"});
}

TEST_CASE("a node that does not belong is refused with both values") {
    const auto refusal = [](auto edit) {
        Handshake handshake(started(), {"build-1", 0xabc});
        schema::HelloT hello = hello_of(schema::Role::gp, 1, 102);
        edit(hello);
        try {
            say(handshake, hello);
        } catch (const MachineError& error) {
            CHECK(error.code == 69);
            return std::string(error.what());
        }
        return std::string("no error");
    };
    CHECK(refusal([](schema::HelloT&) {}) == "no error");
    CHECK(refusal([](schema::HelloT& h) { h.build = "build-2"; }) ==
          "gp-1 is of build 'build-2', the host of build 'build-1'");
    CHECK(refusal([](schema::HelloT& h) { h.schema_hash = 0xabd; }) ==
          "gp-1 has messages of schema 0000000000000abd, the host of schema 0000000000000abc");
    CHECK(refusal([](schema::HelloT& h) { h.pid = 7; }) ==
          "process 7 says that it is gp-1, which is process 102");
    CHECK(refusal([](schema::HelloT& h) { h.index = 2; }) ==
          "process 102 says that it is gp-2, which was not started");
    CHECK(refusal([](schema::HelloT& h) { h.index = 0; }) ==
          "node 2 says that it is gp-0, which is node 1");
    CHECK(refusal([](schema::HelloT& h) { h.endpoint.clear(); }) ==
          "gp-1 does not say where it can be reached");
    Handshake handshake(started(), {"build-1", 0xabc});
    say(handshake, hello_of(schema::Role::gp, 1, 102));
    CHECK_THROWS_WITH_AS(say(handshake, hello_of(schema::Role::gp, 1, 102)),
                         "gp-1 said Hello twice", MachineError);
    CHECK_THROWS_WITH_AS(handshake.connected(77),
                         "node 77 says that it is connected, but was not started", MachineError);
}
