#include "host/scene/ground.hpp"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace pxpl5::host {

namespace {

constexpr int full = 255;

int channel_of(std::uint32_t pixel, unsigned channel) {
    return static_cast<int>(pixel >> (8 * channel) & 0xffU);
}

std::uint32_t without_ground(std::uint32_t over_black, std::uint32_t over_white, int samples) {
    int difference = 0;
    for (unsigned channel = 0; channel < 3; ++channel) {
        difference += channel_of(over_white, channel) - channel_of(over_black, channel);
    }
    const auto rounded = [](int numerator, int divisor) {
        return (numerator + divisor / 2) / divisor;
    };
    const int ground = std::clamp(rounded(difference * samples, 3 * full), 0, samples);
    const int seen = samples - ground;
    if (seen == 0) {
        return 0;
    }
    auto pixel = static_cast<std::uint32_t>(rounded(full * seen, samples)) << 24U;
    for (unsigned channel = 0; channel < 3; ++channel) {
        const int color = rounded(channel_of(over_black, channel) * samples, seen);
        pixel |= static_cast<std::uint32_t>(std::min(color, full)) << (8 * channel);
    }
    return pixel;
}

}  // namespace

std::vector<std::uint32_t> without_ground(std::span<const std::uint32_t> over_black,
                                          std::span<const std::uint32_t> over_white, int samples) {
    assert(over_black.size() == over_white.size());
    std::vector<std::uint32_t> pixels(over_black.size());
    for (std::size_t at = 0; at < pixels.size(); ++at) {
        pixels[at] = without_ground(over_black[at], over_white[at], samples);
    }
    return pixels;
}

}  // namespace pxpl5::host
