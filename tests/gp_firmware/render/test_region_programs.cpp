#include <doctest/doctest.h>

#include <stdexcept>
#include <vector>

#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;
using namespace pxpl5::gp;
using pxpl5::test::words_of;

namespace {

const RegionGrid grid = region_grid(4 * 128, 128, 0);

void put(RegionPrograms& programs, std::size_t region, std::uint32_t word, std::size_t count) {
    std::uint32_t* words = programs.append(region, count);
    for (std::size_t i = 0; i < count; ++i) {
        words[i] = word;
    }
}

/// Adds a triangle of surface word `surface` to region 0.
void add(RegionPrograms& programs, std::uint32_t surface) {
    const auto first = static_cast<std::uint32_t>(programs.corner_count());
    GridVertex* corners = programs.add_corners(3);
    corners[0] = {0, 0, 5000, 0};
    corners[1] = {400, 0, 6000, 0};
    corners[2] = {0, 400, 7000, 0};
    programs.add(0, {first, first + 1, first + 2, surface});
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
        programs.end_frame();

        const auto regions = programs.regions();
        REQUIRE(regions.size() == 3);
        CHECK(regions[0].segments == std::vector<Segment>{{0, 4, 0, 5}});
        CHECK(regions[1].segments.empty());
        CHECK(regions[2].segments ==
              std::vector<Segment>{{0, 4, 0, 1}, {0, 5, 1, 2}, {1, 5, 3, 1}});
        CHECK(words_of(programs, 2, grid) == std::vector<std::uint32_t>{41, 50, 50, 60});
    }
    TEST_CASE("triangles and words that are there already keep their order") {
        namespace shape = isa::triangle;
        // Any number of triangles, so that vectors end in the middle.
        const std::vector<std::size_t> triangles_between = {3, 0, 17, 1, 64, 0, 130};
        RegionPrograms programs;
        programs.begin_frame(1, true);
        programs.begin_slab(2, 0);
        std::vector<std::uint32_t> expected;  // The surface word of each triangle, and raw words.
        std::uint32_t number = 0;
        for (const std::size_t count : triangles_between) {
            for (std::size_t i = 0; i < count; ++i) {
                add(programs, ++number);
                expected.push_back(number);
            }
            put(programs, 0, ++number, 1);
            expected.push_back(number);
        }
        programs.end_frame();

        const auto words = words_of(programs, 0, grid);
        std::vector<std::uint32_t> found;
        for (std::size_t at = 0; at < words.size(); ++at) {
            if (words[at] == shape::enable_word) {
                at += shape::at_surface;
                REQUIRE(at < words.size());
            }
            found.push_back(words[at]);
        }
        CHECK(found == expected);
        CHECK(programs.regions()[0].origins.size() == expected.size());
        CHECK(programs.regions()[0].segments ==
              std::vector<Segment>{{2, 0, 0, static_cast<std::uint32_t>(words.size())}});
    }
    TEST_CASE("words survive growth") {
        RegionPrograms programs;
        programs.begin_frame(1);
        programs.begin_slab(0, 0);
        for (std::uint32_t i = 0; i < 10000; ++i) {
            put(programs, 0, i, 3);
        }
        const auto words = words_of(programs, 0, grid);
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
        CHECK(programs.regions()[3].word_count() == 0);
        CHECK(programs.regions()[3].segments.empty());
        CHECK(programs.corner_count() == 0);
    }
    TEST_CASE("more corners than a number can name are refused") {
        RegionPrograms programs;
        programs.begin_frame(1);
        programs.add_corners(3);
        CHECK_THROWS_WITH_AS(programs.add_corners(max_corners),
                             "3 and 2147483648 corners in one frame; 2147483648 at most",
                             std::invalid_argument);
    }
}
