#include <doctest/doctest.h>

#include "ringbus/channel_model.hpp"

using namespace pxpl5::bus;

namespace {

/// Round numbers: one byte takes 1 ns, one hop 10 ns, the header 8 bytes.
const RingParameters simple{2, 1'000'000'000, 10, 2, 4};
const std::vector<NodeId> ring = {0, 4, 7, 9};

}  // namespace

TEST_SUITE("ringbus/channel_model") {
    TEST_CASE("a message holds its channel for its words and the header's") {
        const ChannelModel model(simple, ring);
        CHECK(model.occupancy_ns(0) == 8);
        CHECK(model.occupancy_ns(4) == 12);
        CHECK(model.occupancy_ns(5) == 16);
        // One megabyte over a channel of 80 MB/s takes 13.1 ms.
        CHECK(ChannelModel(RingParameters{}, ring).occupancy_ns(1 << 20) == 13'107'300);
    }

    TEST_CASE("hops are counted in the ring's one direction") {
        const ChannelModel model(simple, ring);
        CHECK(model.hops(0, 4) == 1);
        CHECK(model.hops(0, 9) == 3);
        CHECK(model.hops(9, 0) == 1);
        CHECK(model.hops(7, 4) == 3);
    }

    TEST_CASE("messages take the channel that is free first, and wait when none is") {
        ChannelModel model(simple, ring);
        const Stamp a = model.place(0, 4, 92), b = model.place(0, 7, 92), c = model.place(0, 9, 92);
        CHECK(a.channel == 0);
        CHECK(b.channel == 1);
        CHECK(a.departure_ns == 0);
        CHECK(a.arrival_ns == 110);
        CHECK(b.departure_ns == 0);
        CHECK(b.arrival_ns == 120);
        CHECK(c.channel == 0);
        CHECK(c.departure_ns == 100);
        CHECK(c.arrival_ns == 230);
    }

    TEST_CASE("a destination takes one message at a time") {
        ChannelModel model(simple, ring);
        const Stamp a = model.place(0, 4, 92), b = model.place(0, 4, 92);
        CHECK(b.channel == 1);
        CHECK(b.departure_ns == a.departure_ns + 100);
        CHECK(b.arrival_ns == a.arrival_ns + 100);
    }

    TEST_CASE("nothing departs before the sender's modelled time") {
        ChannelModel model(simple, ring);
        model.advance_to(5000);
        CHECK(model.place(0, 4, 0).departure_ns == 5000);
        model.advance_to(10);
        CHECK(model.place(0, 7, 0).departure_ns >= 5000);
    }
}
