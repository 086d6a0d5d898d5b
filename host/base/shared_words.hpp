// 32-bit words that several owners read: the pixels or the depths of a picture.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace pxpl5::host {

/// Words that do not change. They lie in a vector, or where another object has them, for example in
/// a message. Copies share the words, and the last copy frees them.
class SharedWords {
  public:
    SharedWords() = default;
    /// Takes the words of a vector. Not explicit: a vector that is moved is as good.
    SharedWords(std::vector<std::uint32_t> words)  // NOLINT(google-explicit-constructor)
        : SharedWords(std::make_shared<const std::vector<std::uint32_t>>(std::move(words))) {}
    /// Words that live as long as `owner`.
    SharedWords(std::span<const std::uint32_t> words, std::shared_ptr<const void> owner)
        : words_(words), owner_(std::move(owner)) {}

    SharedWords(const SharedWords&) = default;
    SharedWords& operator=(const SharedWords&) = default;
    /// Leaves `other` empty.
    SharedWords(SharedWords&& other) noexcept
        : words_(std::exchange(other.words_, {})), owner_(std::move(other.owner_)) {}
    SharedWords& operator=(SharedWords&& other) noexcept {
        words_ = std::exchange(other.words_, {});
        owner_ = std::move(other.owner_);
        return *this;
    }
    ~SharedWords() = default;

    const std::uint32_t* data() const { return words_.data(); }
    std::size_t size() const { return words_.size(); }
    bool empty() const { return words_.empty(); }
    auto begin() const { return words_.begin(); }
    auto end() const { return words_.end(); }
    std::uint32_t operator[](std::size_t index) const { return words_[index]; }
    /// The words as a vector of the caller's own.
    std::vector<std::uint32_t> copy() const { return {begin(), end()}; }

    /// Whether the words are equal, wherever they lie.
    friend bool operator==(const SharedWords& a, const SharedWords& b) {
        return std::ranges::equal(a.words_, b.words_);
    }

  private:
    explicit SharedWords(const std::shared_ptr<const std::vector<std::uint32_t>>& words)
        : words_(*words), owner_(words) {}

    std::span<const std::uint32_t> words_;
    std::shared_ptr<const void> owner_;
};

}  // namespace pxpl5::host
