// Growing: a list that does not clear new elements and that keeps its capacity.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "gp_firmware/render/own_pages.hpp"

namespace pxpl5::gp {

/// A list of plain values for data that each frame writes once and in order.
template <typename T>
class Growing {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignof(std::max_align_t));

  public:
    Growing() = default;
    Growing(Growing&& other) noexcept
        : memory_(std::move(other.memory_)), size_(std::exchange(other.size_, 0)) {}
    Growing& operator=(Growing&& other) noexcept {
        memory_ = std::move(other.memory_);
        size_ = std::exchange(other.size_, 0);
        return *this;
    }

    /// Appends `count` elements and returns the first. The caller writes all of them.
    T* append(std::size_t count) {
        if (capacity() - size_ < count) [[unlikely]] {
            grow(count);
        }
        T* values = values_of() + size_;
        size_ += count;
        return values;
    }
    /// Removes all elements. The capacity stays.
    void clear() { size_ = 0; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    const T* data() const { return values_of(); }
    std::span<const T> values() const { return {values_of(), size_}; }

  private:
    T* values_of() const { return reinterpret_cast<T*>(memory_.data()); }

    std::size_t capacity() const { return memory_.bytes() / sizeof(T); }

    void grow(std::size_t count) {
        constexpr std::size_t first_capacity = 256, most = PTRDIFF_MAX / 4 / sizeof(T);
        if (count > most - size_) {
            throw std::bad_alloc();
        }
        memory_.grow(size_ * sizeof(T),
                     std::max({first_capacity, 2 * capacity(), size_ + count}) * sizeof(T));
    }

    OwnPages memory_;
    std::size_t size_ = 0;
};

}  // namespace pxpl5::gp
