#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "gp_firmware/render/assignment.hpp"
#include "tests/gp_firmware/render/support.hpp"

using namespace pxpl5;

namespace {

std::vector<std::uint64_t> loads(std::span<const std::uint16_t> assignment, std::size_t renderers,
                                 std::span<const std::uint64_t> costs) {
    std::vector<std::uint64_t> sums(renderers, 0);
    for (std::size_t i = 0; i < assignment.size(); ++i) {
        sums.at(assignment[i]) += costs[i];
    }
    return sums;
}

}  // namespace

TEST_SUITE("gp/assignment") {
    TEST_CASE("without costs regions go round-robin") {
        CHECK(gp::assign_regions(5, 2, {}) == std::vector<std::uint16_t>{0, 1, 0, 1, 0});
    }
    TEST_CASE("costs of another number of regions do not count") {
        const std::vector<std::uint64_t> costs = {9, 1, 1};
        CHECK(gp::assign_regions(4, 2, costs) == std::vector<std::uint16_t>{0, 1, 0, 1});
    }
    TEST_CASE("the dearest goes first, ties go to the lower index") {
        // 7 to Renderer 0, 5 to 1, the first 3 to 1 (5 < 7), the second to 0, 2 to 1 (8 < 10).
        const std::vector<std::uint64_t> costs = {3, 7, 2, 5, 3};
        CHECK(gp::assign_regions(5, 2, costs) == std::vector<std::uint16_t>{1, 0, 1, 1, 0});
    }
    TEST_CASE("regions that cost nothing are spread") {
        const std::vector<std::uint64_t> costs(6, 0);
        CHECK(gp::assign_regions(6, 3, costs) == std::vector<std::uint16_t>{0, 1, 2, 0, 1, 2});
    }
    TEST_CASE("a Renderer that takes no more is passed over, whatever it has to do") {
        // 9 to Renderer 0; then 1 has less to do, but takes 3 only.
        const std::vector<std::uint64_t> costs = {9, 1, 1, 1, 1};
        CHECK(gp::assign_regions(5, 2, costs, 3) == std::vector<std::uint16_t>{0, 1, 1, 1, 0});
        CHECK(gp::assign_regions(5, 2, costs, 4) == std::vector<std::uint16_t>{0, 1, 1, 1, 1});
        CHECK(gp::assign_regions(6, 2, std::vector<std::uint64_t>(6, 0), 3) ==
              std::vector<std::uint16_t>{0, 1, 0, 1, 0, 1});
    }
    TEST_CASE("no Renderer has more than 4/3 of what the best balance could give it") {
        // Graham's bound, against the two lower bounds of the best: the mean and the dearest
        // region.
        for (std::uint64_t round = 0; round < 50; ++round) {
            test::Random random(round);
            const auto renderers = static_cast<std::size_t>(random.integer(1, 16));
            std::vector<std::uint64_t> costs(static_cast<std::size_t>(random.integer(32, 200)));
            for (std::uint64_t& cost : costs) {
                cost = static_cast<std::uint64_t>(random.integer(1, 100));
            }
            const auto sums =
                loads(gp::assign_regions(costs.size(), renderers, costs), renderers, costs);
            const double total =
                static_cast<double>(std::accumulate(costs.begin(), costs.end(), std::uint64_t{0}));
            const double mean = total / static_cast<double>(renderers);
            const double dearest = static_cast<double>(*std::ranges::max_element(costs));
            CHECK(static_cast<double>(*std::ranges::max_element(sums)) <=
                  std::max(mean + dearest / 3, dearest) * 4 / 3);
        }
    }
}
