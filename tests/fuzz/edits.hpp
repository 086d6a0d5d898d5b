// Edits of bytes, from the bytes of an input.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tests/fuzz/fuzz.hpp"

namespace pxpl5::fuzz {

/// Replaces 1, 2, 4 or 8 bytes at a multiple of their number. The number of places must be above 0.
inline void overwrite(Bytes& bytes, std::span<std::uint8_t> target) {
    const auto place = bytes.take<std::uint32_t>();
    const auto choice = bytes.take<std::uint8_t>();
    const std::size_t width = std::size_t{1} << choice % 4;
    if (target.size() < width) {
        return;
    }
    constexpr std::array<std::uint64_t, 8> values = {0,      1,           2,           0x7fff,
                                                     0xffff, 0x4000'0000, 0x7fff'ffff, ~0ULL};
    const std::uint64_t value =
        (choice & 4U) != 0 ? values.at(choice / 8 % 8) : bytes.take<std::uint64_t>();
    std::memcpy(target.data() + place % (target.size() / width) * width, &value, width);
}

/// `base` after the edits of an input: overwritten, removed and repeated bytes.
inline std::vector<std::uint8_t> edited(std::vector<std::uint8_t> base, Bytes& bytes) {
    constexpr int most_edits = 16;
    for (int edit = 0; edit < most_edits && !bytes.empty() && !base.empty(); ++edit) {
        const auto kind = bytes.take<std::uint8_t>() % 4;
        if (kind < 2) {
            overwrite(bytes, base);
            continue;
        }
        const auto at = static_cast<std::ptrdiff_t>(bytes.take<std::uint32_t>() % base.size());
        const auto length = static_cast<std::ptrdiff_t>(bytes.take<std::uint16_t>());
        const auto count = std::min(length, std::ssize(base) - at);
        if (kind == 2) {
            base.erase(base.begin() + at, base.begin() + at + count);
        } else {
            const std::vector<std::uint8_t> part(base.begin() + at, base.begin() + at + count);
            base.insert(base.begin() + at, part.begin(), part.end());
        }
    }
    return base;
}

}  // namespace pxpl5::fuzz
