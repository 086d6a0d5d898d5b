#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/serve/encoding/reduce.hpp"

namespace pxpl5::host::serve {
namespace {

using Words = std::vector<std::uint32_t>;

/// Every byte varies, and quickly.
Words noise(const Size& size, int pictures) {
    Words words(static_cast<std::size_t>(size.width * size.height * pictures));
    std::uint32_t state = 7;
    for (std::uint32_t& word : words) {
        state = state * 1664525U + 1013904223U;
        word = state ^ state >> 15U;
    }
    return words;
}

/// Length of the part of old pixel `old_at` that new pixel `new_at` covers.
double covered(int old_at, int new_at, int old_px, int new_px) {
    const double step = static_cast<double>(old_px) / new_px;
    return std::max(0.0, std::min(old_at + 1.0, (new_at + 1) * step) -
                             std::max(static_cast<double>(old_at), new_at * step));
}

/// The mean of a channel over a new pixel, from its definition.
double mean_of(const Words& words, const Size& from, const Size& to, int picture, int x, int y,
               unsigned channel) {
    double sum = 0, area = 0;
    for (int v = 0; v < from.height; ++v) {
        for (int u = 0; u < from.width; ++u) {
            const double part =
                covered(u, x, from.width, to.width) * covered(v, y, from.height, to.height);
            const int at = (picture * from.height + v) * from.width + u;
            sum += part * (words[static_cast<std::size_t>(at)] >> (8 * channel) & 0xffU);
            area += part;
        }
    }
    return sum / area;
}

}  // namespace

TEST_CASE("a pixel of a reduced picture is the mean of the area that it covers") {
    constexpr int pictures = 2;
    for (const auto& [from, to] : std::vector<std::pair<Size, Size>>{{{16, 12}, {8, 6}},
                                                                     {{16, 12}, {12, 9}},
                                                                     {{13, 7}, {10, 5}},
                                                                     {{9, 11}, {9, 8}},
                                                                     {{5, 5}, {1, 1}}}) {
        const Words words = noise(from, pictures);
        const Words reduced = reduced_pixels(words, from, to, pictures);
        REQUIRE(reduced.size() == static_cast<std::size_t>(to.width * to.height * pictures));
        for (int i = 0; i < static_cast<int>(reduced.size()); ++i) {
            const int x = i % to.width, y = i / to.width % to.height;
            for (unsigned channel = 0; channel < 4; ++channel) {
                const double mean =
                    mean_of(words, from, to, i / (to.width * to.height), x, y, channel);
                const auto value = reduced[static_cast<std::size_t>(i)] >> (8 * channel) & 0xffU;
                CHECK(std::abs(value - mean) <= 0.5 + 1e-9);
            }
        }
    }
}

TEST_CASE("halves are rounded up, and a picture of one color keeps it") {
    const Words four{0xff000001, 0xff000002, 0xff000001, 0xff000002};
    CHECK(reduced_pixels(four, {2, 2}, {1, 1}, 1) == Words{0xff000002});
    const Words plain(640 * 480, 0xfffe807f);
    CHECK(reduced_pixels(plain, {640, 480}, {480, 360}, 1) == Words(480 * 360, 0xfffe807f));
    const Words white(64 * 64, 0xffffffff);
    CHECK(reduced_pixels(white, {64, 64}, {63, 33}, 1) == Words(63 * 33, 0xffffffff));
}

TEST_CASE("pixels and depths of the same size stay") {
    const Words words = noise({9, 6}, 4);
    CHECK(reduced_pixels(words, {9, 6}, {9, 6}, 4) == words);
    CHECK(reduced_depths(words, {9, 6}, {9, 6}, 4) == words);
}

TEST_CASE("a depth of a reduced picture is that of the pixel at its middle") {
    Words rows(8);  // Two pictures of 4 x 1.
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
        rows[i] = 100 + i;
    }
    CHECK(reduced_depths(rows, {4, 1}, {2, 1}, 2) == Words{101, 103, 105, 107});
    CHECK(reduced_depths(rows, {4, 1}, {3, 1}, 2) == Words{100, 102, 103, 104, 106, 107});
    CHECK(reduced_depths(rows, {4, 2}, {4, 1}, 1) == Words{104, 105, 106, 107});
}

TEST_CASE("a moving picture has at least 64 pixels a side unless the picture has less") {
    CHECK(moving_size({512, 384}, 0.75) == Size{384, 288});
    CHECK(moving_size({512, 100}, 0.5) == Size{256, 64});
    CHECK(moving_size({50, 1000}, 0.5) == Size{50, 500});
}

}  // namespace pxpl5::host::serve
