// Seed of random tests.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <cstdlib>
#include <random>

namespace pxpl5::test {

/// The seed of PXPL5_SEED, or a fixed one.
inline std::uint64_t ring_seed() {
    const char* text = std::getenv("PXPL5_SEED");
    return text == nullptr ? 19'930'501 : std::strtoull(text, nullptr, 10);
}

}  // namespace pxpl5::test
