// Colors of maps: a sequential scale for counts, a set for categories; both chosen for eyes that
// do not tell red from green.
#pragma once

#include <cstdint>

namespace pxpl5::host::inspect {

struct Rgb8 {
    std::uint8_t r = 0, g = 0, b = 0;
    std::uint32_t opaque() const {
        return r | std::uint32_t{g} << 8 | std::uint32_t{b} << 16 | 0xFF000000U;
    }
};

/// From dark violet at 0 over green to yellow at 1, lightness growing evenly.
/// Source: viridis of N. Smith and S. van der Walt, 2015 (CC0): nine of its colors, mixed.
Rgb8 sequential(double t);

/// A color for each number: first those of Okabe and Ito 2008, in the end any hue.
Rgb8 categorical(std::uint32_t number);

/// Each of the signed components, -1..1, as one of red, green and blue.
Rgb8 directional(double x, double y, double z);

/// part of `over`, the rest of `under`; 0..1.
Rgb8 mix(Rgb8 under, Rgb8 over, double part);

}  // namespace pxpl5::host::inspect
