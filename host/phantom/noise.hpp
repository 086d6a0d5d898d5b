// Noise and waves that are the same on every machine: integer hashes and polynomials, no libm.
#pragma once

#include <cmath>
#include <cstdint>

namespace pxpl5::host::phantom {

/// Mixes the bits of a number: a bijection without visible pattern.
/// Source: the constants of C. Wellons, "Prospecting for hash functions" (public domain).
constexpr std::uint32_t mixed(std::uint32_t h) {
    h = (h ^ (h >> 16)) * 0x21f0aaadU;
    h = (h ^ (h >> 15)) * 0xd35a2d97U;
    return h ^ (h >> 15);
}

/// One of about 2^32 values, even in [0, 1).
constexpr float even(std::uint32_t key) {
    return static_cast<float>(static_cast<std::int32_t>(mixed(key) >> 8)) * (1.0F / 16777216.0F);
}

/// Bell-shaped, mean 0, deviation 1, in (-3.5, 3.5): the sum of the four bytes of a hash.
constexpr float grain(std::uint32_t key) {
    const std::uint32_t h = mixed(key);
    const std::uint32_t pairs = (h & 0x00ff00ffU) + ((h >> 8) & 0x00ff00ffU);
    const std::int32_t sum = static_cast<std::int32_t>((pairs + (pairs >> 16)) & 0x3ffU);
    return static_cast<float>(sum - 510) * (1.0F / 147.8F);
}

/// The nearest integer. The int conversion vectorizes where floor() does not.
inline float nearest(float t) {
    const float shifted = t + (t >= 0 ? 0.5F : -0.5F);
    return static_cast<float>(static_cast<std::int32_t>(shifted));
}

/// Nearly a sine, within 0.002, of an angle in turns. For textures.
inline float wave(float turns) {
    const float t = turns - nearest(turns);
    const float y = 8 * t - 16 * t * std::abs(t);
    return 0.775F * y + 0.225F * y * std::abs(y);
}

/// The sine of an angle in turns, within 1e-12.
double sine(double turns);

}  // namespace pxpl5::host::phantom
