// A node's counts of its time and its messages.
#include "ringbus/activity.hpp"

#include <doctest/doctest.h>

#include <map>
#include <numeric>

#include "ringbus/wire.hpp"
#include "tests/ringbus/wire_bytes.hpp"

using namespace pxpl5::bus;
using pxpl5::test::WireBytes;

namespace {

constexpr NodeId peer = 4;

/// Time and number of entries of each stage, by name.
std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> told(StageClock& clock) {
    std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> told;
    for (const StageClock::Stage& stage : clock.stages()) {
        told[std::string(stage.name)] = {stage.ns, stage.count};
    }
    return told;
}

/// Long enough for a coarse clock.
void spend_time() {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::microseconds(50)) {
    }
}

}  // namespace

TEST_SUITE("ringbus/activity") {
    TEST_CASE("an inner stage interrupts the outer stage, which then continues") {
        StageClock clock;
        {
            const StageClock::In outer(&clock, "outer");
            spend_time();
            {
                const StageClock::In inner(&clock, "inner");
                spend_time();
                CHECK(clock.current() == "inner");
            }
            CHECK(clock.current() == "outer");
        }
        CHECK(clock.current() == stage::wait);
        const auto stages = told(clock);
        CHECK(stages.at("outer").second == 2);  // Begun, and gone on.
        CHECK(stages.at("inner").second == 1);
        CHECK(stages.at("outer").first >= 50'000);
        CHECK(stages.at("inner").first >= 50'000);
    }

    TEST_CASE("entering the current stage again is not counted") {
        StageClock clock;
        for (int i = 0; i < 5; ++i) {
            clock.enter("a");
        }
        clock.enter("b");
        clock.enter("a");
        CHECK(told(clock).at("a").second == 2);
        CHECK(told(clock).at("b").second == 1);
    }

    TEST_CASE("time that is moved to another stage is neither lost nor doubled") {
        StageClock clock;
        clock.enter("a");
        spend_time();
        const std::uint64_t before = told(clock).at("a").first;
        clock.move("a", "b", 30'000);
        auto stages = told(clock);
        CHECK(stages.at("b").first == 30'000);
        CHECK(stages.at("a").first >= before - 30'000);
        // No more time can be moved than the stage has.
        clock.enter("c");
        const std::uint64_t left = told(clock).at("a").first;
        clock.move("a", "b", 1'000'000'000'000);
        stages = told(clock);
        CHECK(stages.at("a").first == 0);
        CHECK(stages.at("b").first == 30'000 + left);
    }

    TEST_CASE("an answer has all stages but waiting, and no more time than the wall clock") {
        StageClock clock;
        {
            const StageClock::In working(&clock, "work");
            spend_time();
        }
        const Traffic traffic{{{peer, Body::SetSurface, 3, 2, 100}}, 7, 800};
        const Message message = WireBytes(activity_message(clock, traffic, {1000, 2, 3}, 4)).read();
        const auto& activity = *message.as<schema::Activity>();
        REQUIRE(activity.stages()->size() == 1);
        CHECK(activity.stages()->Get(0)->name()->str() == "work");
        CHECK(activity.stages()->Get(0)->ns() < activity.wall_ns());
        CHECK(activity.cpu_ns() > 0);
        REQUIRE(activity.sent()->size() == 1);
        CHECK(activity.sent()->Get(0)->destination() == peer);
        CHECK(activity.sent()->Get(0)->kind() == static_cast<std::uint16_t>(Body::SetSurface));
        CHECK(activity.sent()->Get(0)->channel() == 3);
        CHECK(activity.received_messages() == 7);
        CHECK(activity.received_bytes() == 800);
        CHECK(activity.memory_bytes() == 1000);
        CHECK(activity.queue() == 2);
        CHECK(activity.frames() == 3);
        CHECK(activity.held_up() == 4);
    }

    TEST_CASE("messages are counted by receiver, kind and the channel that their headers name") {
        Wire wire(3);
        wire.set_model(ChannelModel(RingParameters{}, {3, peer, 5}));
        std::map<std::uint16_t, std::uint64_t> by_channel;
        for (int i = 0; i < 20; ++i) {
            ++by_channel[wire.header_for(peer, Body::Slices, 1000).channel()];
        }
        CHECK(by_channel.size() == 8);  // Each message takes the channel that is free first.
        wire.header_for(5, Body::Slices, 1);
        wire.header_for(peer, Body::VolumeEnd, 2);
        std::map<std::uint16_t, std::uint64_t> counted;
        std::uint64_t others = 0, bytes = 0;
        for (const SentCount& sum : wire.traffic().sent) {
            bytes += sum.bytes;
            if (sum.to == peer && sum.kind == Body::Slices) {
                counted[sum.channel] += sum.messages;
            } else {
                others += sum.messages;
            }
        }
        CHECK(counted == by_channel);
        CHECK(others == 2);
        CHECK(bytes == 20 * 1000 + 1 + 2);
    }

    TEST_CASE("observation changes no counts and takes no time on the modelled ring") {
        Wire looked_at(3), alone(3);
        for (Wire* wire : {&looked_at, &alone}) {
            wire->set_model(ChannelModel(RingParameters{}, {3, peer}));
        }
        const schema::Header activity = looked_at.header_for(peer, Body::Activity, 5000);
        CHECK(activity.arrival_ns() == 0);
        const schema::Header seen = looked_at.header_for(peer, Body::Slices, 1000),
                             unseen = alone.header_for(peer, Body::Slices, 1000);
        CHECK(seen.sequence() == 1);  // It is numbered like any other.
        CHECK(seen.channel() == unseen.channel());
        CHECK(seen.departure_ns() == unseen.departure_ns());
        CHECK(seen.arrival_ns() == unseen.arrival_ns());
        REQUIRE(looked_at.traffic().sent.size() == 1);
        CHECK(looked_at.traffic().sent[0].kind == Body::Slices);

        Wire receiver(peer);
        receiver.accept(activity);
        CHECK(receiver.traffic().received_messages == 0);
        receiver.accept(seen);
        CHECK(receiver.traffic().received_messages == 1);
        CHECK(receiver.traffic().received_bytes == 1000);
    }
}
