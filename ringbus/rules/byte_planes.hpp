// Values as planes of bytes, which compress well. Plain, for every stage.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace pxpl5 {

namespace byte_planes {

template <class Word>
void split(std::span<const std::byte> values, std::span<std::byte> planes) {
    const std::size_t count = values.size() / sizeof(Word);
    Word before = 0;
    for (std::size_t i = 0; i < count; ++i) {
        Word value{};
        std::memcpy(&value, values.data() + i * sizeof value, sizeof value);
        const auto difference = static_cast<Word>(value - before);
        before = value;
        for (std::size_t k = 0; k < sizeof(Word); ++k) {
            planes[k * count + i] = static_cast<std::byte>(difference >> (8 * k) & 0xff);
        }
    }
}

template <class Word>
void join(std::span<const std::byte> planes, std::span<std::byte> values) {
    const std::size_t count = values.size() / sizeof(Word);
    Word value = 0;
    for (std::size_t i = 0; i < count; ++i) {
        Word difference = 0;
        for (std::size_t k = 0; k < sizeof(Word); ++k) {
            const auto byte = static_cast<std::uint32_t>(planes[k * count + i]);
            difference = static_cast<Word>(difference | byte << (8 * k));
        }
        value = static_cast<Word>(value + difference);
        std::memcpy(values.data() + i * sizeof value, &value, sizeof value);
    }
}

/// Calls `work` with a zero of the unsigned type of `bytes` bytes.
template <class Work>
void with_word(std::size_t bytes, Work&& work) {
    assert(bytes == 1 || bytes == 2 || bytes == 4);
    if (bytes == 1) {
        work(std::uint8_t{});
    } else if (bytes == 2) {
        work(std::uint16_t{});
    } else {
        work(std::uint32_t{});
    }
}

}  // namespace byte_planes

/// Writes byte k of the differences of all values to the value before, then byte k + 1. In smooth
/// data, the high bytes are almost equal.
///
/// value_bytes  Size of a value: 1, 2 or 4; little endian.
/// planes       As many bytes as `values`, and other ones.
inline void split_into_planes(std::span<const std::byte> values, std::size_t value_bytes,
                              std::span<std::byte> planes) {
    byte_planes::with_word(value_bytes,
                           [&]<class Word>(Word) { byte_planes::split<Word>(values, planes); });
}

/// The inverse of split_into_planes().
inline void join_planes(std::span<const std::byte> planes, std::size_t value_bytes,
                        std::span<std::byte> values) {
    byte_planes::with_word(value_bytes,
                           [&]<class Word>(Word) { byte_planes::join<Word>(planes, values); });
}

}  // namespace pxpl5
