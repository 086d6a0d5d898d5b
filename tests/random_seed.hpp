// The seed and the number of random tests.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace pxpl5::test {

/// Returns the seed in the environment variable PXPL5_SEED, or `usual` if that is not set.
template <class Seed = std::uint64_t>
Seed seed_or(Seed usual) {
    const char* text = std::getenv("PXPL5_SEED");
    return text == nullptr ? usual : static_cast<Seed>(std::strtoull(text, nullptr, 0));
}

/// Returns how many of `usual` seeds a test tries: sanitizers take ten times as long, and look for
/// faults of the program's memory, which the first seeds show.
constexpr int seed_count(int usual) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    return (usual + 4) / 5;
#else
    return usual;
#endif
}

}  // namespace pxpl5::test
