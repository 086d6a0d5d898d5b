#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <random>

#include "tests/host/phigs/support.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5;
using namespace pxpl5::test;

namespace {

double area(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& n) {
    return glm::dot(glm::cross(b - a, c - a), n) / 2;
}

/// Every triangle runs as the polygon does, and together they have its area: so they cover it once.
void check_covers_once(const std::vector<glm::dvec3>& corners) {
    const glm::dvec3 newell = phigs::newell_normal(corners);
    const glm::dvec3 n = glm::normalize(newell);
    const auto indices = phigs::triangulate(corners, newell);
    REQUIRE(indices.size() == 3 * (corners.size() - 2));
    double sum = 0;
    for (std::size_t i = 0; i < indices.size(); i += 3) {
        const double a =
            area(corners[indices[i]], corners[indices[i + 1]], corners[indices[i + 2]], n);
        CHECK(a > -1e-9);
        sum += a;
    }
    CHECK(sum == doctest::Approx(glm::length(newell) / 2));
}

}  // namespace

TEST_SUITE("phigs/triangulate") {
    TEST_CASE("the normal of a square is twice its area long, wherever it lies") {
        const std::vector<glm::dvec3> square = {
            {1e6, 2, 3}, {1e6 + 2, 2, 3}, {1e6 + 2, 4, 3}, {1e6, 4, 3}};
        CHECK(phigs::newell_normal(square) == glm::dvec3(0, 0, 8));
    }
    TEST_CASE("a concave polygon is covered once: an L, a comb, in all planes and windings") {
        const std::vector<glm::dvec2> ell = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
        const std::vector<glm::dvec2> comb = {{0, 0}, {7, 0}, {7, 3}, {6, 3}, {6, 1}, {4, 1},
                                              {4, 3}, {3, 3}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
        for (const auto& shape : {ell, comb}) {
            for (int plane = 0; plane < 6; ++plane) {
                std::vector<glm::dvec3> corners;
                for (const glm::dvec2& p : shape) {
                    glm::dvec3 q(0.5);
                    q[plane % 3] = p.x;
                    q[(plane + 1) % 3] = p.y;
                    corners.push_back(q);
                }
                if (plane >= 3) {
                    std::reverse(corners.begin(), corners.end());
                }
                check_covers_once(corners);
            }
        }
    }
    TEST_CASE("random stars in random planes are covered once") {
        const std::uint64_t seed = seed_or<std::uint64_t>(1);
        std::mt19937_64 random(seed);
        CAPTURE(seed);
        std::uniform_real_distribution<double> unit(0, 1);
        for (int round = 0; round < 50; ++round) {
            const glm::dvec3 u = glm::normalize(glm::dvec3(unit(random), unit(random), 1));
            const glm::dvec3 v = glm::normalize(glm::cross(u, glm::dvec3(unit(random), 1, 0)));
            std::vector<glm::dvec3> corners;
            const int count = 3 + static_cast<int>(unit(random) * 40);
            for (int i = 0; i < count; ++i) {
                const double angle = glm::two_pi<double>() * i / count;
                const double reach = 0.2 + unit(random);
                corners.push_back((u * std::cos(angle) + v * std::sin(angle)) * reach);
            }
            check_covers_once(corners);
        }
    }
}
