#include <doctest/doctest.h>

#include <map>

#include "ringbus/zmq/arena_blocks.hpp"
#include "tests/random_seed.hpp"

using pxpl5::bus::ArenaBlocks;

TEST_SUITE("ringbus/arena_blocks") {
    TEST_CASE("the lowest fitting block is allocated, in whole cache lines") {
        ArenaBlocks blocks(640);
        CHECK(blocks.take(1) == 0);
        CHECK(blocks.take(65) == 64);
        CHECK(blocks.take(64) == 192);
        blocks.give_back(64, 65);
        CHECK(blocks.take(129) == 256);  // 128 bytes are free below.
        CHECK(blocks.take(128) == 64);
        CHECK(blocks.end_in_use() == 448);
    }

    TEST_CASE("a block that does not fit is refused without a change") {
        ArenaBlocks blocks(256);
        CHECK(!blocks.take(257));
        CHECK(!blocks.take(~std::size_t{0}));
        CHECK(blocks.take(256) == 0);
        CHECK(blocks.end_in_use() == 256);
        CHECK(!blocks.take(1));
        blocks.give_back(0, 256);
        CHECK(blocks.end_in_use() == 0);
        CHECK(blocks.take(256) == 0);
    }

    TEST_CASE("blocks in use never overlap, and released blocks merge") {
        constexpr std::size_t size = 1 << 20;
        const std::uint64_t seed = pxpl5::test::seed_or<std::uint64_t>(19'930'501);
        INFO("PXPL5_SEED=", seed);
        std::mt19937_64 random(seed);
        ArenaBlocks blocks(size);
        std::map<std::size_t, std::size_t> in_use;
        for (int step = 0; step < 20'000; ++step) {
            if (random() % 2 == 0 && !in_use.empty()) {
                auto any = in_use.lower_bound(random() % size);
                any = any == in_use.end() ? in_use.begin() : any;
                blocks.give_back(any->first, any->second);
                in_use.erase(any);
                continue;
            }
            const std::size_t bytes = 1 + random() % 20'000;
            if (const auto offset = blocks.take(bytes)) {
                const auto [block, is_new] = in_use.emplace(*offset, bytes);
                REQUIRE(is_new);
                REQUIRE(*offset + bytes <= size);
                const auto after = std::next(block);
                REQUIRE((after == in_use.end() || *offset + bytes <= after->first));
                REQUIRE((block == in_use.begin() ||
                         std::prev(block)->first + std::prev(block)->second <= *offset));
            }
        }
        for (const auto& [offset, bytes] : in_use) {
            blocks.give_back(offset, bytes);
        }
        CHECK(blocks.end_in_use() == 0);
        CHECK(blocks.take(size) == 0);
    }
}
