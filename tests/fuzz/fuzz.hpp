// A fuzz target: a function that checks the meaning of one input.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace pxpl5::fuzz {

using Input = std::span<const std::uint8_t>;

/// Gives one input to the product and checks the product's promises. Each target defines it once.
///
/// Returns  true if the product accepted the input, false if it refused the input with the error
///          that it documents. A broken promise ends the process.
bool accepts(Input input);

/// Ends the process with `text` unless `holds`. libFuzzer then saves the input.
inline void require(bool holds, std::string_view text) {
    if (!holds) {
        std::fprintf(stderr, "broken promise: %.*s\n", static_cast<int>(text.size()), text.data());
        std::abort();
    }
}

/// Takes values from the front of an input. Beyond its end all bytes are 0.
class Bytes {
  public:
    explicit Bytes(Input input) : left_(input) {}

    bool empty() const { return left_.empty(); }
    Input rest() const { return left_; }
    std::string text() const { return {left_.begin(), left_.end()}; }

    template <typename Number>
    Number take() {
        static_assert(std::is_trivially_copyable_v<Number>);
        Number value{};
        const std::size_t count = std::min(sizeof value, left_.size());
        std::memcpy(static_cast<void*>(&value), left_.data(), count);
        left_ = left_.subspan(count);
        return value;
    }
    /// The bytes before the next `mark`, which is removed; all bytes if there is none.
    std::string text_before(std::uint8_t mark) {
        const auto at = std::ranges::find(left_, mark);
        const std::string text(left_.begin(), at);
        left_ = left_.subspan(std::min(text.size() + 1, left_.size()));
        return text;
    }

  private:
    Input left_;
};

}  // namespace pxpl5::fuzz
