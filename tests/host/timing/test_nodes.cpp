// A GP's processor, mail between nodes, and shares that are dealt out.
#include <doctest/doctest.h>

#include <vector>

#include "host/timing/replay/deal.hpp"
#include "host/timing/replay/hardware.hpp"
#include "tests/host/timing/machines.hpp"

namespace pxpl5::host::timing {

using namespace testing;

TEST_CASE("messages go before other work, which is that much later") {
    Events events;
    Processor processor(events);
    std::vector<Ns> done;
    processor.work(1000, [&] { done.push_back(events.now()); });
    processor.work(1000, [&] { done.push_back(events.now()); });
    Ns first = 0, second = 0;
    events.at(300, [&] {
        first = processor.message(50);
        second = processor.message(70);
    });
    events.at(1500, [&] { processor.message(10); });
    events.run();
    CHECK(first == 350);
    CHECK(second == 420);
    CHECK(done == std::vector<Ns>{1120, 2130});
    CHECK(processor.busy().at(events.now()) == 2130);
}

TEST_CASE("work that is asked for between messages begins behind them") {
    Events events;
    Processor processor(events);
    Ns done = 0;
    processor.message(100);
    processor.work(1000, [&] { done = events.now(); });
    events.run();
    CHECK(done == 1100);
}

TEST_CASE("the host's messages cross its link one after the other") {
    Hardware machine(round_machine());
    std::vector<Ns> taken;
    for (std::size_t gp = 0; gp < 2; ++gp) {
        machine.mail.send(machine.places.host(), machine.places.gp(gp), 1000,
                          [&] { taken.push_back(machine.events.now()); });
    }
    machine.events.run();
    // Software 100 us each, one after the other; the link 1 us a word; the ring; the GP's 10 us.
    constexpr Ns ring = 1002 * 50;
    CHECK(taken == std::vector<Ns>{100'000 + 1'000'000 + ring + 1 * 50 + 10'000,
                                   100'000 + 2'000'000 + ring + 2 * 50 + 10'000});
    CHECK(machine.mail.link().at(machine.events.now()) == 2'000'000);
}

TEST_CASE("a message to the host crosses the link, then is the software's") {
    Hardware machine(round_machine());
    Ns taken = 0;
    machine.mail.send(machine.places.gp(35), machine.places.host(), 8,
                      [&] { taken = machine.events.now(); });
    machine.events.run();
    // Behind GP 35 come 16 Renderers and 2 ports.
    CHECK(taken == 10'000 + 10 * 50 + 19 * 50 + 8'000 + 100'000);
}

TEST_CASE("a deal gives every primitive, word and cycle away once, and goes round") {
    Deal deal(7);
    std::vector<Hand> sums(7);
    const auto give = [&](const Hand& hand) {
        sums.at(hand.gp).primitives += hand.primitives;
        sums[hand.gp].words += hand.words;
        sums[hand.gp].cycles += hand.cycles;
    };
    Hand all;
    for (std::uint64_t list = 0; list < 50; ++list) {
        const std::uint64_t primitives = 1 + list * 5 % 23;
        const Hand whole{0, primitives, primitives * 34 + list % 3, list * 1001};
        all.primitives += whole.primitives;
        all.words += whole.words;
        all.cycles += whole.cycles;
        deal(whole, give);
    }
    Hand sum;
    for (const Hand& hand : sums) {
        CHECK(hand.primitives >= all.primitives / 7);  // As cards: none has two more than another.
        CHECK(hand.primitives <= all.primitives / 7 + 1);
        sum.primitives += hand.primitives;
        sum.words += hand.words;
        sum.cycles += hand.cycles;
    }
    CHECK(sum.primitives == all.primitives);
    CHECK(sum.words == all.words);
    CHECK(sum.cycles == all.cycles);
}

TEST_CASE("words without a primitive are somebody's, too") {
    Deal deal(7);
    std::uint64_t words = 0;
    deal({0, 0, 5, 9}, [&](const Hand& hand) {
        words += hand.words;
        CHECK(hand.primitives == 0);
        CHECK(hand.cycles == 9);
    });
    CHECK(words == 5);
}

TEST_CASE("a node without primitives of a list has no word of the list") {
    Deal deal(36);
    std::size_t hands = 0;
    deal({0, 3, 102, 696}, [&](const Hand& hand) {
        ++hands;
        CHECK(hand.primitives == 1);
        CHECK(hand.words == 34);
        CHECK(hand.cycles == 232);
    });
    CHECK(hands == 3);
}

}  // namespace pxpl5::host::timing
