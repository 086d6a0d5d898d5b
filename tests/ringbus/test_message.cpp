#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "tests/random_seed.hpp"
#include "tests/ringbus/examples/examples.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5::bus;
using namespace pxpl5::test;

TEST_SUITE("ringbus/message") {
    TEST_CASE("a packed message is read back unchanged") {
        const Message message = WireBytes(pack(example_draw())).read();
        CHECK(message.kind() == Body::DrawFrame);
        CHECK(message.source() == 3);
        REQUIRE(message.as<schema::DrawFrame>() != nullptr);
        CHECK(message.as<schema::DrawFrame>()->width() == 300);
        CHECK(message.as<schema::DrawFrame>()->surfaces()->Get(0)->color().g() == 8);
        CHECK(message.as<schema::BeginFrame>() == nullptr);
    }

    TEST_CASE("a copy of a message keeps its bytes alive") {
        auto wire = std::make_unique<WireBytes>(pack(example_draw()));
        const Message copy = wire->read();
        wire.reset();
        CHECK(copy.as<schema::DrawFrame>()->height() == 200);
    }

    TEST_CASE("each damaged header field is refused by name, with both values") {
        WireBytes wire(pack(example_draw()));
        WireBytes magic = wire, version = wire, size = wire, kind = wire, none = wire, other = wire;
        WireBytes reserved = wire, channel = wire, time = wire;
        magic.header.mutate_magic(1);
        version.header.mutate_version(9);
        size.header.mutate_body_bytes(12);
        kind.header.mutate_kind(999);
        none.header.mutate_kind(0);
        reserved.header.mutate_reserved(6);
        channel.header.mutate_channel(64);
        time.header.mutate_departure_ns(5);
        other.header.mutate_kind(static_cast<std::uint16_t>(Body::BeginFrame));
        CHECK(contains(refusal(magic), "magic is 1, expected 894"));
        CHECK(contains(refusal(version), "version is 9, expected 5"));
        CHECK(contains(refusal(size), "expected 12"));
        const auto last_kind = static_cast<int>(Body::MAX);
        CHECK(contains(refusal(kind), "kind is 999, expected " + std::to_string(last_kind)));
        CHECK(contains(refusal(none), "kind is 0, expected 1"));
        CHECK(contains(refusal(reserved), "reserved field is 6, expected 0"));
        CHECK(contains(refusal(channel), "channel is 64, expected 63"));
        CHECK(contains(refusal(time), "departure is 5, expected 0"));
        CHECK(contains(refusal(other), "the header says BeginFrame, the body is DrawFrame"));
        CHECK(contains(refusal(kind), "from node 3"));
        CHECK(refusal(wire).empty());
    }

    TEST_CASE("a refused message names its sender and its number") {
        WireBytes wire(pack(example_draw()));
        wire.bytes()[4] = 'X';  // In the file identifier.
        try {
            wire.read();
            FAIL("accepted");
        } catch (const BadMessage& bad) {
            CHECK(bad.source == 3);
            CHECK(bad.sequence == 7);
            CHECK(contains(bad.what(), "DrawFrame 7 from node 3: its "));
            CHECK(contains(bad.what(), "bytes are not a valid message"));
        }
    }

    TEST_CASE("a body with more tables than the limit is refused") {
        flatbuffers::FlatBufferBuilder builder;
        // A million and one elements share one table. The verifier counts each.
        schema::RegionProgramT region;
        const auto one = schema::RegionProgram::Pack(builder, &region);
        const std::vector<flatbuffers::Offset<schema::RegionProgram>> many(max_body_tables, one);
        const auto programs =
            schema::CreateRegionPrograms(builder, 1, 0, builder.CreateVector(many));
        CHECK(contains(refusal(finish(builder, programs)), "not a valid message"));
    }

    TEST_CASE("each kind has a name and an example") {
        const std::vector<Payload> all = one_of_each_kind();
        REQUIRE(all.size() == static_cast<std::size_t>(Body::MAX));
        for (std::size_t i = 0; i < all.size(); ++i) {
            CHECK(static_cast<std::size_t>(all[i].kind()) == i + 1);
        }
        CHECK(kind_name(Body::RegionPrograms) == "RegionPrograms");
        CHECK(kind_name(static_cast<Body>(200)) == "kind 200");
    }

    TEST_CASE("a message of each kind crosses unchanged, to the last field") {
        for (const Payload& payload : one_of_each_kind()) {
            CAPTURE(kind_name(payload.kind()));
            const Message message = WireBytes(payload).read();
            CHECK(message.kind() == payload.kind());
            const Payload again = repacked(message);
            CHECK(std::ranges::equal(again.bytes(), payload.bytes()));
        }
    }

    TEST_CASE(
        "a message of each kind that is cut anywhere is refused, unless only padding is lost") {
        for (const Payload& payload : one_of_each_kind()) {
            const WireBytes whole(payload);
            const std::size_t step = whole.size > 4096 ? 1021 : 1;
            for (std::size_t size = 0; size < whole.size; size += step) {
                WireBytes cut = whole;
                cut.size = size;
                cut.header.mutate_body_bytes(size);
                CAPTURE(kind_name(payload.kind()));
                CAPTURE(size);
                if (refusal(cut).empty()) {
                    CHECK(whole.size - size < 4);
                    CHECK(std::ranges::equal(repacked(cut.read()).bytes(), payload.bytes()));
                }
            }
        }
    }

    TEST_CASE("damage in a message of any kind is refused, or leaves a message that can be read") {
        const unsigned seed = pxpl5::test::seed_or(20260101U);
        CAPTURE(seed);
        std::mt19937 random(seed);
        int refused = 0, read = 0;
        for (const Payload& payload : one_of_each_kind()) {
            const std::size_t reach = std::min<std::size_t>(payload.bytes().size(), 512);
            for (int i = 0; i < 400; ++i) {
                WireBytes spoiled(payload);
                for (std::size_t flips = 1 + random() % 3; flips > 0; --flips) {
                    spoiled.bytes()[random() % reach] ^=
                        static_cast<std::uint8_t>(1U << random() % 8);
                }
                if (refusal(spoiled).empty()) {
                    CHECK(repacked(spoiled.read()).kind() == payload.kind());
                    ++read;
                } else {
                    ++refused;
                }
            }
        }
        CHECK(refused > 1000);
        CHECK(read > 100);
    }
}
