#include "ringbus/door.hpp"

#include <doctest/doctest.h>

#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5::bus;
using pxpl5::test::contains;
using pxpl5::test::WireBytes;
using schema::Role;

namespace {

constexpr NodeId gp_id = 3, stranger_id = 77;
const schema::Secret secret(0x0123456789abcdef, 0xfedcba9876543210);

schema::Header header_of(NodeId source, Body kind) {
    schema::Header header = WireBytes(pack(schema::GoT{})).header;
    header.mutate_source(source);
    header.mutate_kind(static_cast<std::uint16_t>(kind));
    return header;
}

/// A door of the host that keeps what it reports.
struct Reported {
    Door door{Role::host};
    std::vector<Refusal> refusals;
    Reported() {
        door.on_refusal([this](const Refusal& refusal) { refusals.push_back(refusal); });
    }
    bool lets_in(NodeId source, Body kind) { return door.lets_in(header_of(source, kind)); }
    bool says_hello(Role role, const schema::Secret* said) {
        schema::HelloT hello;
        hello.role = role;
        hello.endpoint = "ipc:///x";
        if (said != nullptr) {
            hello.secret = std::make_unique<schema::Secret>(*said);
        }
        const Payload payload = pack(hello);
        return door.lets_join(header_of(gp_id, Body::Hello),
                              *schema::GetMessage(payload.bytes().data())->body_as_Hello(), secret);
    }
};

}  // namespace

TEST_SUITE("ringbus/door") {
    TEST_CASE("only the host may give orders, and nodes answer only to it") {
        for (const Body kind :
             {Body::Topology, Body::Go, Body::Shutdown, Body::SaveTrace, Body::ImportVolume,
              Body::ExportPicture, Body::ExportMesh, Body::ReadMesh, Body::ReadArchive}) {
            CAPTURE(kind_name(kind));
            for (const Role sender : {Role::gp, Role::renderer, Role::frame_buffer, Role::io}) {
                for (const Role receiver :
                     {Role::host, Role::gp, Role::renderer, Role::frame_buffer, Role::io}) {
                    CHECK(!may_send(sender, kind, receiver));
                }
            }
        }
        CHECK(may_send(Role::host, Body::Shutdown, Role::io));
        CHECK(!may_send(Role::host, Body::ImportVolume, Role::gp));
        CHECK(may_send(Role::renderer, Body::RegionPixels, Role::frame_buffer));
        CHECK(!may_send(Role::gp, Body::RegionPixels, Role::frame_buffer));
        CHECK(!may_send(Role::io, Body::FrameDone, Role::host));
        CHECK(!may_send(Role::io, Body::Slices, Role::gp));
        CHECK(!may_send(Role::gp, Body::NONE, Role::host));
        CHECK(!may_send(static_cast<Role>(99), Body::Go, Role::gp));
        CHECK(!may_send(Role::gp, static_cast<Body>(200), Role::host));
    }

    TEST_CASE("messages of unknown nodes are counted, and named once") {
        Reported host;
        host.door.admit(gp_id, Role::gp);
        for (int i = 0; i < 3; ++i) {
            CHECK(!host.lets_in(stranger_id, Body::FrameDone));
            CHECK(!host.lets_in(0xffff, Body::FrameDone));
        }
        CHECK(host.lets_in(gp_id, Body::SurfaceBuilt));
        CHECK(host.door.refused() == 6);
        REQUIRE(host.refusals.size() == 1);
        CHECK(host.refusals[0].reason == RefusalReason::unknown_sender);
        CHECK(!host.refusals[0].has_joined);
        CHECK(host.refusals[0].text ==
              "FrameDone from node 77, which is not a node of this machine");
    }

    TEST_CASE("a role with an entrance of its own has no other, and other nodes may not use it") {
        Reported host;
        host.door.keep_apart(Role::io);
        host.door.admit(gp_id, Role::gp);
        host.door.admit(4, Role::io);
        const auto built = header_of(gp_id, Body::SurfaceBuilt), done = header_of(4, Body::IoDone);
        CHECK(host.door.lets_in(built, Entrance::common));
        CHECK(host.door.lets_in(done, Entrance::apart));
        CHECK(host.door.refused() == 0);
        for (int i = 0; i < 2; ++i) {
            CHECK(!host.door.lets_in(built, Entrance::apart));
            CHECK(!host.door.lets_in(done, Entrance::common));
        }
        CHECK(host.door.refused() == 4);
        REQUIRE(host.refusals.size() == 1);
        CHECK(host.refusals[0].reason == RefusalReason::wrong_entrance);
        CHECK(!host.refusals[0].has_joined);  // The node that the header names did not send it.
        CHECK(host.refusals[0].text ==
              "SurfaceBuilt from node 3, on the socket for nodes of role io");
        Reported other;
        other.door.keep_apart(Role::io);
        other.door.expect(4, Role::io);
        CHECK(!other.door.lets_in(header_of(4, Body::Hello), Entrance::common));
        CHECK(other.refusals.at(0).text ==
              "Hello from node 4, on the socket for nodes of roles other than io");
        CHECK(other.door.lets_in(header_of(4, Body::Hello), Entrance::apart));
    }

    TEST_CASE("a kind that the sender's role may not send is named once per node") {
        Reported host;
        host.door.admit(gp_id, Role::gp);
        host.door.admit(4, Role::io);
        for (const NodeId source : {gp_id, gp_id, NodeId{4}}) {
            CHECK(!host.lets_in(source, Body::FrameDone));
        }
        CHECK(host.door.refused() == 3);
        REQUIRE(host.refusals.size() == 2);
        CHECK(host.refusals[1].source == 4);
        CHECK(host.refusals[1].has_joined);
        CHECK(host.refusals[1].text ==
              "FrameDone from node 4, which a node of role io may not send to a node of role host");
    }

    TEST_CASE("a started node says Hello, then Connected, then it may send all of its kinds") {
        Reported host;
        host.door.expect(gp_id, Role::gp);
        CHECK(!host.lets_in(gp_id, Body::Connected));
        CHECK(!host.lets_in(gp_id, Body::SurfaceBuilt));
        CHECK(host.lets_in(gp_id, Body::Hello));
        REQUIRE(host.says_hello(Role::gp, &secret));
        host.door.admit(gp_id, Role::gp);  // As add_peer() does.
        CHECK(!host.lets_in(gp_id, Body::Hello));
        CHECK(!host.lets_in(gp_id, Body::SurfaceBuilt));
        CHECK(host.lets_in(gp_id, Body::Fault));
        CHECK(host.lets_in(gp_id, Body::Connected));
        host.door.connect(gp_id);
        CHECK(!host.lets_in(gp_id, Body::Connected));
        CHECK(!host.lets_in(gp_id, Body::Hello));
        CHECK(host.lets_in(gp_id, Body::SurfaceBuilt));
    }

    TEST_CASE("a Hello with a wrong secret, without one, or of another role changes nothing") {
        Reported host;
        host.door.expect(gp_id, Role::gp);
        const schema::Secret low(secret.low() ^ 1, secret.high()), none,
            high(secret.low(), secret.high() ^ (std::uint64_t{1} << 63));
        CHECK(!host.says_hello(Role::gp, nullptr));
        CHECK(!host.says_hello(Role::gp, &none));
        CHECK(!host.says_hello(Role::gp, &low));
        CHECK(!host.says_hello(Role::gp, &high));
        CHECK(!host.says_hello(Role::io, &secret));
        CHECK(host.door.refused() == 5);
        REQUIRE(host.refusals.size() == 1);
        CHECK(contains(host.refusals[0].text, "Hello from node 3, without the secret of this"));
        CHECK(host.says_hello(Role::gp, &secret));
    }

    TEST_CASE("late messages of a node that has ended are dropped, and its number can be reused") {
        Reported host;
        host.door.admit(gp_id, Role::gp);
        host.door.forget(gp_id);
        CHECK(!host.lets_in(gp_id, Body::SurfaceBuilt));
        CHECK(host.door.refused() == 0);
        host.door.admit(gp_id, Role::frame_buffer);
        CHECK(host.lets_in(gp_id, Body::FrameDone));
        host.door.forget(gp_id);
        host.door.expect(gp_id, Role::gp);
        CHECK(host.lets_in(gp_id, Body::Hello));
    }
}
