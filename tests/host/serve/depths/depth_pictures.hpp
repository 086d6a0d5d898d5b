// Depths of pictures from a seed, for tests of what is sent to the page.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "isa/contract/region_layout.hpp"

namespace pxpl5::host::serve::test {

struct DepthPicture {
    std::string name;
    int width = 0, height = 0;
    std::vector<std::uint32_t> depths = {};  ///< Words of FrameDone.

    std::uint32_t at(int x, int y) const {
        return depths[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(x)];
    }
};

/// Pictures of every kind and of odd sizes: nothing, all covered at random depths, random holes,
/// and discs that slope.
inline std::vector<DepthPicture> depth_pictures(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto below = [&](std::uint32_t end) {
        return static_cast<std::uint32_t>(random() % end);
    };
    const auto any_depth = [&] {
        return isa::region::z_margin + below(isa::region::z_far - 2 * isa::region::z_margin);
    };
    std::vector<DepthPicture> pictures;
    const std::vector<std::pair<int, int>> sizes = {{1, 1}, {1, 37}, {41, 1},  {4, 4},
                                                    {5, 3}, {8, 9},  {64, 48}, {131, 77}};
    for (const auto& [width, height] : sizes) {
        const std::string size = std::to_string(width) + " x " + std::to_string(height);
        const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
        DepthPicture none{"nothing, " + size, width, height};
        none.depths.assign(count, isa::region::z_far << 8U);
        DepthPicture noise{"noise, " + size, width, height};
        DepthPicture holes{"holes, " + size, width, height};
        DepthPicture disc{"disc, " + size, width, height};
        const double slope = below(20'000);
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                noise.depths.push_back(any_depth() << 8U | (1 + below(255)));
                const bool is_hole = below(8) != 0;
                holes.depths.push_back(is_hole ? 0 : any_depth() << 8U | 1U);
                const double radius = std::hypot(x - width / 2.0, y - height / 2.0);
                const auto depth = static_cast<std::uint32_t>(8'000'000 + slope * (x - y));
                disc.depths.push_back(radius < std::max(width, height) / 3.0 ? depth << 8U | 2U
                                                                             : 0U);
            }
        }
        pictures.insert(pictures.end(), {none, noise, holes, disc});
    }
    return pictures;
}

}  // namespace pxpl5::host::serve::test
