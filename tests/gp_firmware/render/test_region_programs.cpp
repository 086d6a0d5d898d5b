#include <doctest/doctest.h>

#include "gp_firmware/render/region_programs.hpp"

using namespace pxpl5::gp;

namespace {

void put(RegionPrograms& programs, std::size_t region, std::uint32_t word, std::size_t count) {
    std::uint32_t* words = programs.append(region, count);
    for (std::size_t i = 0; i < count; ++i) {
        words[i] = word;
    }
}

}  // namespace

TEST_SUITE("gp/region programs") {
    TEST_CASE("each slab's words form one segment of each region that got some") {
        RegionPrograms programs;
        programs.begin_frame(3);
        programs.begin_slab(0, 4);
        put(programs, 0, 40, 2);
        put(programs, 2, 41, 1);
        put(programs, 0, 42, 3);
        programs.begin_slab(0, 5);
        put(programs, 2, 50, 2);
        programs.begin_slab(1, 5);
        put(programs, 2, 60, 1);

        const auto regions = programs.regions();
        REQUIRE(regions.size() == 3);
        CHECK(regions[0].segments == std::vector<Segment>{{0, 4, 0, 5}});
        CHECK(regions[1].segments.empty());
        CHECK(regions[2].segments ==
              std::vector<Segment>{{0, 4, 0, 1}, {0, 5, 1, 2}, {1, 5, 3, 1}});
        const auto words = regions[2].words.words();
        CHECK(std::vector(words.begin(), words.end()) ==
              std::vector<std::uint32_t>{41, 50, 50, 60});
    }
    TEST_CASE("words survive growth") {
        RegionPrograms programs;
        programs.begin_frame(1);
        programs.begin_slab(0, 0);
        for (std::uint32_t i = 0; i < 10000; ++i) {
            put(programs, 0, i, 3);
        }
        const auto words = programs.regions()[0].words.words();
        REQUIRE(words.size() == 30000);
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < words.size(); ++i) {
            wrong += words[i] != i / 3 ? 1 : 0;
        }
        CHECK(wrong == 0);
    }
    TEST_CASE("a new frame starts empty, whatever its number of regions") {
        RegionPrograms programs;
        programs.begin_frame(4);
        programs.begin_slab(0, 0);
        put(programs, 3, 1, 5);
        programs.begin_frame(2);
        CHECK(programs.regions().size() == 2);
        programs.begin_frame(4);
        CHECK(programs.regions()[3].words.size() == 0);
        CHECK(programs.regions()[3].segments.empty());
    }
}
