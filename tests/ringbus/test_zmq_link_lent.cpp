#include <doctest/doctest.h>

#include <cstring>
#include <zmq.hpp>

#include "ringbus/wire.hpp"
#include "ringbus/zmq/arena.hpp"
#include "tests/ringbus/ipc_address.hpp"
#include "tests/ringbus/large_bodies.hpp"
#include "tests/ringbus/test_zmq_link_peer.hpp"

using namespace pxpl5;
using namespace pxpl5::bus;
using pxpl5::test::is_whole;
using pxpl5::test::large_slices;
using pxpl5::test::next_of;

namespace {

constexpr std::size_t body_bytes = 100'000;

/// Node 2, which has opened the arena of node 1. The test makes node 1's messages by hand.
struct Borrower {
    ZmqLink link{{2, schema::Role::gp}, test::ipc_address("borrower")};
    Arena arena;
    Wire wire{1};
    zmq::context_t context{1};
    zmq::socket_t socket{context, zmq::socket_type::push};

    Borrower() {
        link.add_peer(1, schema::Role::host, test::ipc_address("lender"));
        socket.set(zmq::sockopt::linger, 0);
        socket.connect(link.endpoint());
        const Payload payload = body(0);
        const schema::Header header = header_of(payload);
        send_part(header, arena.offer(), zmq::send_flags::sndmore);
        socket.send(zmq::buffer(payload.bytes().data(), payload.bytes().size()));
        CHECK(is_whole(next_of(link), body_bytes, 0));
    }

    Payload body(std::uint32_t number) { return large_slices(&arena, body_bytes, number); }

    schema::Header header_of(const Payload& payload) {
        return wire.header_for(2, payload.kind(), payload.bytes().size());
    }

    template <typename Extra>
    void send_part(const schema::Header& header, const Extra& extra,
                   zmq::send_flags flags = zmq::send_flags::none) {
        zmq::message_t part(sizeof header + sizeof extra);
        std::memcpy(part.data(), &header, sizeof header);
        std::memcpy(part.data<std::uint8_t>() + sizeof header, &extra, sizeof extra);
        socket.send(part, flags);
    }
};

/// Sends a raw message: a header for node 2 and bytes behind it in the same part.
template <typename Extra>
void send_raw(zmq::socket_t& socket, const schema::Header& header, const Extra& extra,
              const Payload* body) {
    zmq::message_t part(sizeof header + sizeof extra);
    std::memcpy(part.data(), &header, sizeof header);
    std::memcpy(part.data<std::uint8_t>() + sizeof header, &extra, sizeof extra);
    socket.send(part, body != nullptr ? zmq::send_flags::sndmore : zmq::send_flags::none);
    if (body != nullptr) {
        socket.send(zmq::buffer(body->bytes().data(), body->bytes().size()));
    }
}

}  // namespace

TEST_SUITE("ringbus/zmq/zmq_link_lent") {
    TEST_CASE("a repeated message does not free the body that is being read") {
        Borrower to;
        Payload payload = to.body(1);
        const std::uint8_t* const place_of_body = payload.bytes().data();
        const schema::Header header = to.header_of(payload);
        const ArenaPlace place = *to.arena.lend(2, payload);
        payload = {};
        to.send_part(header, place);
        std::optional<Message> first = next_of(to.link);
        to.send_part(header, place);
        CHECK_THROWS_WITH_AS(next_of(to.link), "message 1 from node 1 came where 2 was due",
                             WireFault);
        CHECK(to.body(2).bytes().data() != place_of_body);
        CHECK(is_whole(*first, body_bytes, 1));
        first.reset();
        CHECK(to.body(3).bytes().data() == place_of_body);
    }

    TEST_CASE("a repeated message does not free the body of a message in transit") {
        Borrower to;
        const schema::Header header = to.header_of(to.body(1));
        const ArenaPlace place = *to.arena.lend(2, to.body(1));
        to.send_part(header, place);
        CHECK(is_whole(next_of(to.link), body_bytes, 1));
        Payload later = to.body(2);
        const std::uint8_t* const place_of_body = later.bytes().data();
        REQUIRE(to.arena.lend(2, later)->ticket == place.ticket);
        later = {};
        to.send_part(header, place);
        CHECK_THROWS_AS(next_of(to.link), WireFault);
        CHECK(to.body(3).bytes().data() != place_of_body);
    }

    TEST_CASE("a new message that names a ticket again, or one lent to another, frees nothing") {
        Borrower to;
        const auto view_of_3 = ArenaView::open(to.arena.offer(), 3);
        REQUIRE(view_of_3);
        for (const NodeId reader : {NodeId{2}, NodeId{3}}) {
            Payload payload = to.body(1);
            const std::uint8_t* const place_of_body = payload.bytes().data();
            const ArenaPlace place = *to.arena.lend(reader, payload);
            std::optional<Message> first;
            if (reader == 2) {
                to.send_part(to.header_of(payload), place);
                first = next_of(to.link);
            }
            to.send_part(to.header_of(payload), place);
            payload = {};
            CHECK_THROWS_WITH_AS(next_of(to.link), "message from node 1: ticket 0 is not lent",
                                 BadMessage);
            CHECK(to.body(2).bytes().data() != place_of_body);
            CHECK((!first || is_whole(*first, body_bytes, 1)));
        }
    }

    TEST_CASE("an early message is refused, and its body is free") {
        Borrower to;
        Payload payload = to.body(1);
        const std::uint8_t* const place_of_body = payload.bytes().data();
        static_cast<void>(to.header_of(payload));  // Lost.
        to.send_part(to.header_of(payload), *to.arena.lend(2, payload));
        payload = {};
        CHECK_THROWS_WITH_AS(next_of(to.link), "message 2 from node 1 came where 1 was due",
                             WireFault);
        CHECK(to.body(2).bytes().data() == place_of_body);
    }

    TEST_CASE("invalid places are refused, and the next message still arrives") {
        const std::uint64_t seed = test::seed_or<std::uint64_t>(19'930'501);
        INFO("PXPL5_SEED=", seed);
        std::mt19937_64 random(seed);
        ZmqLink link({2, schema::Role::gp}, test::ipc_address("places"));
        link.add_peer(1, schema::Role::host, test::ipc_address("places-1"));
        Arena arena;
        const Payload payload = test::large_slices(&arena, body_bytes, 1);
        zmq::context_t context(1);
        zmq::socket_t socket(context, zmq::socket_type::push);
        socket.set(zmq::sockopt::linger, 0);
        socket.connect(link.endpoint());
        Wire wire(1);
        const auto header = [&] {
            return wire.header_for(2, payload.kind(), payload.bytes().size());
        };
        send_raw(socket, header(), ArenaPlace{}, nullptr);
        CHECK_THROWS_WITH_AS(next_of(link),
                             "message from node 1: its body is at 0 of an arena that was never "
                             "offered",
                             BadMessage);
        send_raw(socket, Wire(1).header_for(2, payload.kind(), 8), ArenaPlace{}, &payload);
        test::await_refusals(link, 1);  // A place and a body, too.
        send_raw(socket, header(), arena.offer(), &payload);
        CHECK(test::is_whole(next_of(link), body_bytes, 1));
        int refused = 0;
        for (int i = 0; i < 2000; ++i) {
            const auto place = arena.lend(2, payload);
            REQUIRE(place);
            ArenaPlace bad = *place;
            schema::Header stated = header();
            bad.offset = random() % 2 == 0 ? random() >> (random() % 64) : bad.offset;
            bad.ticket = random() % 8 == 0 ? static_cast<std::uint32_t>(random()) : bad.ticket;
            if (random() % 2 == 0) {
                stated.mutate_body_bytes(random() >> (random() % 64));
            }
            send_raw(socket, stated, bad, nullptr);
            try {
                const Message good = next_of(link);
                CHECK(test::is_whole(good, body_bytes, 1));
            } catch (const BadMessage&) {
                ++refused;
            }
        }
        CHECK(refused > 1000);
        send_raw(socket, header(), *arena.lend(2, payload), nullptr);
        CHECK(test::is_whole(next_of(link), body_bytes, 1));
    }
}
