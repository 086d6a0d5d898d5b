#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "host/scene/ground.hpp"
#include "tests/random_seed.hpp"

using namespace pxpl5::host;

namespace {

/// A pixel of the machine: the rounded mean of `seen` samples of a surface, and of ground.
std::uint32_t mean_pixel(const std::array<int, 3>& sums, int seen, int samples, int ground) {
    std::uint32_t pixel = 0xff000000U;
    for (unsigned channel = 0; channel < 3; ++channel) {
        const int sum = sums[channel] + (samples - seen) * ground;
        pixel |= static_cast<std::uint32_t>((sum + samples / 2) / samples) << (8 * channel);
    }
    return pixel;
}

int channel_of(std::uint32_t pixel, unsigned channel) {
    return static_cast<int>(pixel >> (8 * channel) & 0xffU);
}

/// The pixel laid over a ground, as a program does that shows the file.
int laid_over(std::uint32_t pixel, unsigned channel, int ground) {
    const double alpha = channel_of(pixel, 3) / 255.0;
    return static_cast<int>(std::lround(alpha * channel_of(pixel, channel) + (1 - alpha) * ground));
}

}  // namespace

TEST_CASE("a picture without ground, laid over any ground, is the picture over this ground") {
    const auto seed = pxpl5::test::seed_or(20261126U);
    CAPTURE(seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> byte(0, 255);
    for (const int samples : {1, 4, 16}) {
        for (int seen = 0; seen <= samples; ++seen) {
            for (int repeat = 0; repeat < 50; ++repeat) {
                std::array<int, 3> sums{};
                for (int& sum : sums) {
                    for (int sample = 0; sample < seen; ++sample) {
                        sum += byte(random);
                    }
                }
                const std::vector black{mean_pixel(sums, seen, samples, 0)};
                const std::vector white{mean_pixel(sums, seen, samples, 255)};
                const std::uint32_t pixel = without_ground(black, white, samples).front();
                CAPTURE(samples);
                CAPTURE(seen);
                CAPTURE(black[0]);
                // The share of the samples, to the nearest of 255 steps.
                CHECK(channel_of(pixel, 3) == (255 * seen + samples / 2) / samples);
                for (const int ground : {0, 18, 128, 255}) {
                    const std::uint32_t drawn = mean_pixel(sums, seen, samples, ground);
                    for (unsigned channel = 0; channel < 3; ++channel) {
                        CHECK(std::abs(laid_over(pixel, channel, ground) -
                                       channel_of(drawn, channel)) <= 1);
                    }
                }
            }
        }
    }
}

TEST_CASE("the color of an edge is that of its surface, and not mixed with a ground") {
    // A quarter of the samples shows a surface of this color.
    const std::array<int, 3> sums{4 * 200, 4 * 120, 4 * 40};
    const std::vector black{mean_pixel(sums, 4, 16, 0)}, white{mean_pixel(sums, 4, 16, 255)};
    CHECK(without_ground(black, white, 16).front() == 0x402878c8U);
}

TEST_CASE("ground alone has no color, and a surface alone keeps its color") {
    const std::vector black{0xff000000U, 0xffffffffU, 0xff000000U};
    const std::vector white{0xffffffffU, 0xffffffffU, 0xff000000U};
    CHECK(without_ground(black, white, 4) ==
          std::vector<std::uint32_t>{0, 0xffffffffU, 0xff000000U});
}
