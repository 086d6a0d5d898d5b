// The text of a region program, assembled during the build.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace pxpl5::renderer::programs {

/// A coefficient word whose value is the parameter `$name`.
struct Open {
    std::string_view name;
    std::size_t word = 0;
};

/// The words of a text. The words in `open` are 0 until their values are bound.
template <std::size_t word_count, std::size_t open_count>
struct Text {
    std::array<std::uint32_t, word_count> words;
    std::array<Open, open_count> open;
};

}  // namespace pxpl5::renderer::programs
