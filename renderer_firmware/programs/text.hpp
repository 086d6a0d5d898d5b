// A region program's text as it was assembled when this was built.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace pxpl5::renderer::programs {

/// A coefficient word that waits for the value of `$name`.
struct Open {
    std::string_view name;
    std::size_t word = 0;
};

/// Words, of which those named in `open` are 0 until they are bound.
template <std::size_t word_count, std::size_t open_count>
struct Text {
    std::array<std::uint32_t, word_count> words;
    std::array<Open, open_count> open;
};

}  // namespace pxpl5::renderer::programs
