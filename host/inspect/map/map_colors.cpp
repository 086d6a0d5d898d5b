#include "host/inspect/map/map_colors.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace pxpl5::host::inspect {

namespace {

constexpr std::array<Rgb8, 9> scale = {{{0x44, 0x01, 0x54},
                                        {0x47, 0x2D, 0x7B},
                                        {0x3B, 0x52, 0x8B},
                                        {0x2C, 0x72, 0x8E},
                                        {0x21, 0x91, 0x8C},
                                        {0x28, 0xAE, 0x80},
                                        {0x5E, 0xC9, 0x62},
                                        {0xAD, 0xDC, 0x30},
                                        {0xFD, 0xE7, 0x25}}};

/// Okabe and Ito's, with a light gray in place of black, and eight more.
constexpr std::array<Rgb8, 16> apart = {{{0xE6, 0x9F, 0x00},
                                         {0x56, 0xB4, 0xE9},
                                         {0x00, 0x9E, 0x73},
                                         {0xF0, 0xE4, 0x42},
                                         {0x00, 0x72, 0xB2},
                                         {0xD5, 0x5E, 0x00},
                                         {0xCC, 0x79, 0xA7},
                                         {0xC8, 0xC8, 0xC8},
                                         {0x99, 0xDD, 0x55},
                                         {0x7B, 0x3F, 0xC8},
                                         {0x8B, 0x45, 0x13},
                                         {0xFF, 0xC0, 0xCB},
                                         {0x80, 0x80, 0x00},
                                         {0x44, 0xE0, 0xD8},
                                         {0xFF, 0x40, 0x40},
                                         {0x50, 0x50, 0x90}}};

std::uint8_t byte_of(double value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255));
}

/// A color of full circle `turn` 0..1 and the given saturation and value.
Rgb8 of_hue(double turn, double saturation, double value) {
    const auto channel = [&](double shift) {
        const double k = std::fmod(shift + turn * 6, 6);
        return byte_of(value - value * saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
    };
    return {channel(5), channel(3), channel(1)};
}

}  // namespace

Rgb8 mix(Rgb8 under, Rgb8 over, double part) {
    const auto channel = [part](std::uint8_t p, std::uint8_t q) {
        return static_cast<std::uint8_t>(std::lround(p + (q - p) * part));
    };
    return {channel(under.r, over.r), channel(under.g, over.g), channel(under.b, over.b)};
}

Rgb8 sequential(double t) {
    const double at = std::clamp(t, 0.0, 1.0) * (scale.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), scale.size() - 2);
    return mix(scale[below], scale[below + 1], at - static_cast<double>(below));
}

Rgb8 categorical(std::uint32_t number) {
    if (number < apart.size()) {
        return apart[number];
    }
    constexpr double golden = 0.61803398875;  // Turns by it never come close to one another soon.
    const double turn = std::fmod(number * golden, 1.0);
    const bool light = number % 2 == 0;
    return of_hue(turn, light ? 0.45 : 0.8, light ? 0.95 : 0.7);
}

Rgb8 directional(double x, double y, double z) {
    return {byte_of(x / 2 + 0.5), byte_of(y / 2 + 0.5), byte_of(z / 2 + 0.5)};
}

}  // namespace pxpl5::host::inspect
