// Times on the ring, from its rules: with round_machine() a word takes 50 ns, a hop 50 ns.
#include <doctest/doctest.h>

#include <map>
#include <random>
#include <utility>
#include <vector>

#include "host/timing/replay/ring.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

using namespace testing;

namespace {

constexpr Ns word = 50, hop = 50;
constexpr std::uint64_t header = 2;

/// A ring of its own, and when the packets of each message came.
struct Bench {
    explicit Bench(const Machine& of = round_machine(), std::size_t places = 20)
        : machine(of), costs(of), ring(of, costs, events, places) {}

    /// At `time`. Returns the message's index in `arrivals`.
    std::size_t send(Ns time, Place source, Place destination, std::uint64_t words,
                     bool stays = false) {
        arrivals.emplace_back();
        messages.push_back({source, destination, words, 0, stays, {}, {}});
        const std::size_t index = messages.size() - 1;
        messages[index].arrives = [this, index](Packet packet) {
            arrivals[index].push_back(events.now());
            words_in += packet.words;
        };
        events.at(time, [this, index] { ring.send(messages[index]); });
        return index;
    }

    Machine machine;
    Costs costs;
    Events events;
    Ring ring;
    std::vector<RingMessage> messages;
    std::vector<std::vector<Ns>> arrivals;
    std::uint64_t words_in = 0;
};

using Times = std::vector<Ns>;

}  // namespace

TEST_CASE("a packet takes its words and header on a channel, and its hops") {
    Bench bench;
    bench.send(1000, 3, 7, 100);
    bench.send(100'000, 7, 3, 100);  // The ring has one direction: 16 of 20 places on.
    bench.events.run();
    CHECK(bench.arrivals[0] == Times{1000 + 102 * word + 4 * hop});
    CHECK(bench.arrivals[1] == Times{100'000 + 102 * word + 16 * hop});
}

TEST_CASE("a message of 2500 words is three packets, one behind the other") {
    Bench bench;
    bench.send(0, 0, 1, 2500);
    bench.events.run();
    // 1024 + 1024 + 452 words, each with a header.
    CHECK(bench.arrivals[0] ==
          Times{1026 * word + hop, 2 * 1026 * word + hop, (2 * 1026 + 454) * word + hop});
    std::uint64_t words = 0, packets = 0;
    for (const RingCount& count : bench.ring.counts()) {
        words += count.words;
        packets += count.messages;
    }
    CHECK(words == 2500 + 3 * header);
    CHECK(packets == 3);
}

TEST_CASE("two senders to one receiver take turns, in the order of their waiting") {
    Bench bench;
    bench.send(0, 2, 9, 1000);
    bench.send(1, 1, 9, 1000);
    bench.send(2, 0, 9, 1000);
    bench.events.run();
    // Each when the one before has left: the ring's other places cannot go meanwhile.
    CHECK(bench.arrivals[0] == Times{1002 * word + 7 * hop});
    CHECK(bench.arrivals[1] == Times{2 * 1002 * word + 8 * hop});
    CHECK(bench.arrivals[2] == Times{3 * 1002 * word + 9 * hop});
}

TEST_CASE("of packets that have waited as long, the lower place's goes first") {
    Bench bench;
    bench.send(0, 5, 9, 1000);
    bench.send(1, 7, 9, 10);
    bench.send(1, 6, 9, 10);
    bench.events.run();
    CHECK(bench.arrivals[2] == Times{(1002 + 12) * word + 3 * hop});
    CHECK(bench.arrivals[1] == Times{(1002 + 24) * word + 2 * hop});
}

TEST_CASE("a packet that cannot go does not hold up others of its sender") {
    Bench bench;
    bench.send(0, 1, 9, 1000);
    bench.send(1, 2, 9, 1000);  // Waits for place 9.
    bench.send(2, 2, 8, 100);
    bench.events.run();
    CHECK(bench.arrivals[2] == Times{2 + 102 * word + 6 * hop});
    CHECK(bench.arrivals[1] == Times{2 * 1002 * word + 7 * hop});
}

TEST_CASE("nine pairs share eight channels") {
    Bench bench;
    for (Place pair = 0; pair < 9; ++pair) {
        bench.send(0, static_cast<Place>(2 * pair), static_cast<Place>(2 * pair + 1), 1000);
    }
    bench.events.run();
    for (std::size_t pair = 0; pair < 8; ++pair) {
        CHECK(bench.arrivals[pair] == Times{1002 * word + hop});
    }
    CHECK(bench.arrivals[8] == Times{2 * 1002 * word + hop});
}

TEST_CASE("a packet waits until all of it has room in the FIFO") {
    Machine machine = round_machine();
    machine.ring_fifo_words = 2048;
    Bench bench(machine);
    bench.send(0, 0, 1, 3 * 1024, true);
    bench.events.at(500'000, [&] { bench.ring.release(1, 1023); });
    bench.events.at(600'000, [&] { bench.ring.release(1, 1); });
    bench.events.run();
    // Two fill it; the third goes when 1024 words have room, not 1023.
    CHECK(bench.arrivals[0] ==
          Times{1026 * word + hop, 2 * 1026 * word + hop, 600'000 + 1026 * word + hop});
}

TEST_CASE("a FIFO that is shorter than a packet takes one nevertheless") {
    Machine machine = round_machine();
    machine.ring_fifo_words = 16;
    Bench bench(machine);
    bench.send(0, 0, 1, 1024, true);
    bench.events.run();
    CHECK(bench.arrivals[0].size() == 1);
}

TEST_CASE("a gate holds up what is behind it") {
    Bench bench;
    bench.send(0, 0, 1, 8);
    bench.messages[0].gate = 2;
    bench.send(0, 2, 1, 8);
    bench.events.at(5000, [&] { bench.ring.open(1, 1); });
    bench.events.at(9000, [&] { bench.ring.open(1, 2); });
    bench.events.run();
    CHECK(bench.arrivals[0] == Times{9000 + 10 * word + hop});
    CHECK(bench.arrivals[1] == Times{10 * word + 19 * hop});
}

TEST_CASE("packets at a port keep their order, though the second comes from nearer") {
    Machine machine = round_machine();
    machine.ring_hop_ns = 5000;
    Bench bench(machine);
    bench.send(0, 10, 9, 8);  // 19 hops.
    bench.send(1, 8, 9, 8);   // 1 hop.
    bench.events.run();
    CHECK(bench.arrivals[0] == Times{10 * word + 19 * 5000});
    CHECK(bench.arrivals[1] == bench.arrivals[0]);
}

// The machine's aggregate: 8 x 80 MB/s = 640 MB/s, 5 Gbit/s. [S: Yoo & Chen, section III]
TEST_CASE("eight pairs that share no place send 640 MB/s") {
    Machine machine = round_machine();
    machine.ring_header_words = 0;  // Which would be 2 of 1026 words.
    Bench bench(machine);
    constexpr std::uint64_t words = 1'000'000;
    for (Place pair = 0; pair < 8; ++pair) {
        bench.send(0, static_cast<Place>(2 * pair), static_cast<Place>(2 * pair + 1), words);
    }
    bench.events.run();
    const double seconds = static_cast<double>(bench.arrivals[0].back() - hop) * 1e-9;
    CHECK(8 * words * 4 / seconds == doctest::Approx(640e6).epsilon(1e-12));
    for (const Meter& channel : bench.ring.channels()) {
        CHECK(channel.at(bench.events.now()) == static_cast<Ns>(words) * word);
    }
}

namespace {

/// Many messages between all places, some at the same time. Returns when the last has come.
Ns traffic(Bench& bench) {
    std::mt19937 random(1);  // The same sequence everywhere, by the standard.
    for (int i = 0; i < 300; ++i) {
        const auto source = static_cast<Place>(random() % 20);
        const auto destination = static_cast<Place>((source + 1 + random() % 19) % 20);
        bench.send(static_cast<Ns>(random() % 50 * 10'000), source, destination,
                   1 + random() % 3000);
    }
    bench.events.run();
    return bench.events.now();
}

}  // namespace

TEST_CASE("what goes in comes out: words by pair and by channel") {
    Bench bench;
    traffic(bench);
    std::map<std::pair<Place, Place>, std::uint64_t> sent;
    std::uint64_t all = 0, packets = 0;
    for (const RingMessage& message : bench.messages) {
        const std::uint64_t cut = (message.words + 1023) / 1024;
        sent[{message.source, message.destination}] += message.words + cut * header;
        all += message.words;
        packets += cut;
    }
    CHECK(bench.words_in == all);
    std::vector<std::uint64_t> on_channel(8);
    std::uint64_t counted = 0;
    for (const RingCount& count : bench.ring.counts()) {
        sent[{count.source, count.destination}] -= count.words;
        on_channel.at(count.channel) += count.words;
        counted += count.messages;
    }
    CHECK(counted == packets);
    for (const auto& [pair, left] : sent) {
        CHECK(left == 0);
    }
    std::uint64_t sum = 0;
    for (std::size_t channel = 0; channel < on_channel.size(); ++channel) {
        sum += on_channel[channel];
        CHECK(bench.ring.channels()[channel].at(bench.events.now()) ==
              static_cast<Ns>(on_channel[channel]) * word);
    }
    CHECK(sum == all + packets * header);
}

TEST_CASE("channels twice as fast halve the ring's time, to the nanosecond") {
    Machine slow = round_machine();
    slow.ring_hop_ns = 0;
    Machine fast = slow;
    fast.ring_channel_mb_s *= 2;
    Bench at_80(slow), at_160(fast);
    const auto all_at_once = [](Bench& bench) {
        for (Place place = 0; place < 20; ++place) {
            bench.send(0, place, static_cast<Place>((place + 7) % 20), 100u * (place + 1u));
            bench.send(0, place, static_cast<Place>((place + 3) % 20), 5000);
        }
        bench.events.run();
        return bench.events.now();
    };
    const Ns slow_time = all_at_once(at_80);
    CHECK(slow_time > 0);
    CHECK(all_at_once(at_160) * 2 == slow_time);
}

TEST_CASE("the same traffic takes the same time, packet by packet") {
    Bench first, second;
    traffic(first);
    traffic(second);
    CHECK(first.arrivals == second.arrivals);
}

}  // namespace pxpl5::host::timing
