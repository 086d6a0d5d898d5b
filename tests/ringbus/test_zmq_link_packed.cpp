// Compressed bodies: they arrive as they were sent, and damaged ones change nothing.
#include <doctest/doctest.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>
#include <zmq.hpp>

#include "ringbus/zmq/packed_body.hpp"
#include "tests/ringbus/ipc_address.hpp"
#include "tests/ringbus/large_bodies.hpp"
#include "tests/ringbus/test_zmq_link_peer.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::contains;
using pxpl5::test::next_of;
using schema::Role;

namespace {

constexpr const char* any_port = "tcp://127.0.0.1:*";
constexpr NodeId gp_id = 1;

Credentials of_a_network() {
    Credentials credentials = make_credentials(Protection::plain_tcp, Reach::network);
    return credentials;
}

Payload slices(const std::vector<std::uint8_t>& values) {
    schema::SlicesT body;
    body.slice_count = 1;
    body.values = values;
    return pack(body);
}

std::vector<std::uint8_t> random_values(std::size_t count) {
    std::mt19937 random(7);
    std::vector<std::uint8_t> values(count);
    std::ranges::generate(values, [&] { return static_cast<std::uint8_t>(random()); });
    return values;
}

/// A receiver that sees the parts of each message.
struct Receiver {
    zmq::context_t context{1};
    zmq::socket_t socket{context, zmq::socket_type::pull};
    Receiver() { socket.bind(any_port); }
    std::string address() const { return socket.get(zmq::sockopt::last_endpoint); }
    /// Sizes of the two parts of the next message.
    std::pair<std::size_t, std::size_t> sizes() {
        zmq::message_t head, body;
        REQUIRE(socket.recv(head).has_value());
        REQUIRE(head.more());
        REQUIRE(socket.recv(body).has_value());
        return {head.size(), body.size()};
    }
};

}  // namespace

TEST_CASE("compressed bodies arrive as they were sent") {
    const Credentials credentials = of_a_network();
    ZmqLink host({host_id, Role::host}, any_port, credentials);
    ZmqLink gp({gp_id, Role::gp}, any_port, credentials);
    host.add_peer(gp_id, Role::gp, gp.endpoint());
    gp.add_peer(host_id, Role::host, host.endpoint());
    for (const bool compresses : {true, false, true}) {
        host.compress_far(compresses);
        for (const std::size_t bytes : {1UL, 1000UL, 100'000UL, 3'000'001UL}) {
            for (const std::vector<std::uint8_t>& values :
                 {std::vector<std::uint8_t>(bytes, 3), random_values(bytes)}) {
                const Payload sent = slices(values);
                host.send(gp_id, sent);
                const Message message = next_of(gp);
                host.receive();  // Credit.
                REQUIRE(message.header().body_bytes() == sent.bytes().size());
                CHECK(std::ranges::equal(*message.as<schema::Slices>()->values(), values));
            }
        }
    }
    // The counts are those of the bodies.
    std::uint64_t sent_bytes = 0;
    for (const SentCount& sent : host.traffic().sent) {
        sent_bytes += sent.kind == Body::Slices ? sent.bytes : 0;
    }
    CHECK(sent_bytes == gp.traffic().received_bytes);
    CHECK(gp.traffic().received_bytes > 6 * 3'100'000);
}

TEST_CASE("only large bodies to other computers are compressed, and only where it saves") {
    const Credentials credentials = of_a_network();
    Receiver receiver;
    ZmqLink host({host_id, Role::host}, any_port, credentials);
    host.add_peer(gp_id, Role::gp, receiver.address());
    const Payload flat = slices(std::vector<std::uint8_t>(100'000, 3));
    const auto sizes_of = [&](const Payload& payload) {
        host.send(gp_id, payload);
        return receiver.sizes();
    };
    const std::size_t plain = sizeof(schema::Header);
    CHECK(sizes_of(flat).second == flat.bytes().size());
    host.compress_far(true);
    CHECK(sizes_of(flat).first == plain + sizeof(PackedBody));
    CHECK(sizes_of(flat).second < flat.bytes().size() / 100);
    const Payload noise = slices(random_values(100'000));
    CHECK(sizes_of(noise) == std::pair(plain, noise.bytes().size()));
    const Payload small = slices(std::vector<std::uint8_t>(100, 3));
    CHECK(sizes_of(small) == std::pair(plain, small.bytes().size()));
}

TEST_CASE("a damaged compressed body is a named fault, and the next message is taken") {
    const Credentials credentials = of_a_network();
    ZmqLink gp({gp_id, Role::gp}, any_port, credentials);
    gp.add_peer(host_id, Role::host, "tcp://127.0.0.1:9");
    test::RawPeer peer(gp.endpoint());
    const Payload payload = slices(std::vector<std::uint8_t>(100'000, 3));
    Packer packer;
    const zmq::message_t sound = *packer.pack(payload.bytes());
    std::uint64_t number = 0;
    const auto answer_to = [&](std::uint64_t body_bytes, PackedBody form,
                               const std::string& packed) -> std::string {
        const schema::Header header{header_magic,
                                    protocol_version,
                                    static_cast<std::uint16_t>(payload.kind()),
                                    host_id,
                                    gp_id,
                                    0,
                                    0,
                                    number++,
                                    body_bytes,
                                    0,
                                    0,
                                    1};
        std::string head(sizeof header + sizeof form, '\0');
        std::memcpy(head.data(), &header, sizeof header);
        std::memcpy(head.data() + sizeof header, &form, sizeof form);
        peer.socket().send(zmq::buffer(head), zmq::send_flags::sndmore);
        peer.socket().send(zmq::buffer(packed));
        try {
            next_of(gp);
            return {};
        } catch (const BadMessage& bad) {
            return bad.what();
        }
    };
    const std::string whole = sound.to_string();
    const std::size_t size = payload.bytes().size();
    CHECK(contains(answer_to(size + 1, {}, whole),
                   fmt::format("states a size of {} bytes, its header {}", size, size + 1)));
    CHECK(contains(answer_to(size, {}, whole.substr(0, whole.size() - 1)), "compressed body"));
    CHECK(contains(answer_to(size, {}, "no frame of zstd"), "states a size of"));
    CHECK(contains(answer_to(size, {2}, whole), "has method 2, expected 1"));
    // Not even a header that agrees makes room for more than a message may have.
    std::vector<char> frame(ZSTD_compressBound(10));
    ZSTD_CCtx* context = ZSTD_createCCtx();
    ZSTD_CCtx_setPledgedSrcSize(context, std::uint64_t{1} << 40U);
    ZSTD_outBuffer to{frame.data(), frame.size(), 0};
    ZSTD_inBuffer from{"0123456789", 10, 0};
    ZSTD_compressStream2(context, &to, &from, ZSTD_e_flush);
    ZSTD_freeCCtx(context);
    CHECK(contains(answer_to(std::uint64_t{1} << 40U, {}, std::string(frame.data(), to.pos)),
                   "compressed body"));
    CHECK(answer_to(size, {}, whole).empty());
}

TEST_CASE("a compressed body from this computer is refused, for example of an io process") {
    const Credentials credentials = of_a_network();
    ZmqLink gp({gp_id, Role::gp}, test::ipc_address("packed-gp"), credentials);
    gp.add_peer(host_id, Role::host, test::ipc_address("packed-host"));
    test::RawPeer peer(gp.endpoint());
    const Payload payload = slices(std::vector<std::uint8_t>(100'000, 3));
    Packer packer;
    const zmq::message_t packed = *packer.pack(payload.bytes());
    const schema::Header header{header_magic,
                                protocol_version,
                                static_cast<std::uint16_t>(payload.kind()),
                                host_id,
                                gp_id,
                                0,
                                0,
                                0,
                                payload.bytes().size(),
                                0,
                                0,
                                1};
    const PackedBody form;
    std::string head(sizeof header + sizeof form, '\0');
    std::memcpy(head.data(), &header, sizeof header);
    std::memcpy(head.data() + sizeof header, &form, sizeof form);
    peer.socket().send(zmq::buffer(head), zmq::send_flags::sndmore);
    peer.socket().send(zmq::buffer(packed.data(), packed.size()));
    CHECK_THROWS_WITH_AS(next_of(gp), "message from node 0: a compressed body from this computer",
                         BadMessage);
}
