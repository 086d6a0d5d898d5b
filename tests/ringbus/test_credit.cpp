#include "ringbus/credit.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <deque>
#include <random>

#include "ringbus/wire.hpp"

using namespace pxpl5::bus;

TEST_SUITE("ringbus/credit") {
    TEST_CASE("bytes and messages in transit are limited") {
        Window bytes;
        bytes.take(batch_bytes);
        CHECK(bytes.has_room(window_bytes - batch_bytes, Body::RegionPrograms));
        CHECK(!bytes.has_room(window_bytes - batch_bytes + 1, Body::RegionPrograms));
        CHECK(bytes.has_room(slices_window_bytes - batch_bytes, Body::Slices));
        CHECK(!bytes.has_room(slices_window_bytes - batch_bytes + 1, Body::Slices));
        Window messages;
        for (std::uint32_t i = 0; i < window_messages; ++i) {
            REQUIRE(messages.has_room(1, Body::Slices));
            messages.take(1);
        }
        CHECK(!messages.has_room(1, Body::Slices));
        CHECK(messages.give_back(1, 1));
        CHECK(messages.has_room(1, Body::Slices));
    }

    TEST_CASE("no more credit returns than was taken") {
        Window window;
        window.take(10);
        CHECK(!window.give_back(2, 5));
        CHECK(!window.give_back(1, 11));
        CHECK(window.give_back(1, 10));
    }

    TEST_CASE("a message of any size leaves eventually, even if credit is withheld") {
        std::mt19937_64 random(7);
        for (int round = 0; round < 2000; ++round) {
            Window window;
            Consumed consumed;
            std::uint64_t most = 0, on_its_way = 0;
            for (int i = 0; i < 300; ++i) {
                const std::size_t size = random() % (max_body_bytes >> (random() % 31)) + 1;
                // The receiver consumes all received messages.
                REQUIRE(window.has_room(size, Body::Slices));
                window.take(size);
                on_its_way += size;
                most = std::max(most, on_its_way);
                consumed.add(size);
                if (consumed.is_due()) {
                    REQUIRE(window.give_back(consumed.messages, consumed.bytes));
                    on_its_way -= consumed.bytes;
                    consumed = {};
                }
            }
            CHECK(most <= batch_bytes + max_body_bytes);
        }
    }

    TEST_CASE("control messages need no credit") {
        for (const Body kind : {Body::Hello, Body::Topology, Body::Connected, Body::Go,
                                Body::Shutdown, Body::Credit}) {
            CHECK(!needs_credit(kind));
        }
        CHECK(needs_credit(Body::Fault));
        CHECK(needs_credit(Body::ImportVolume));
        CHECK(needs_credit(Body::RegionPrograms));
    }

    TEST_CASE("a body beyond the limit is refused before it leaves") {
        Wire wire(3);
        CHECK(wire.header_for(4, Body::Slices, max_body_bytes).body_bytes() == max_body_bytes);
        CHECK_THROWS_WITH_AS(wire.header_for(4, Body::Slices, max_body_bytes + 1),
                             "Slices for node 4 has 1073741825 bytes, a message holds 1073741824 "
                             "at most",
                             NodeFault);
        CHECK(wire.header_for(4, Body::Slices, 1).sequence() == 1);  // No number was lost.
    }
}
