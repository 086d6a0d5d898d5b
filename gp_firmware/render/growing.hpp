// Growing: a list that does not clear new elements and that keeps its capacity.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

namespace pxpl5::gp {

/// A list of plain values for data that each frame writes once and in order.
template <typename T>
class Growing {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    /// Appends `count` elements and returns the first. The caller writes all of them.
    T* append(std::size_t count) {
        if (capacity_ - size_ < count) [[unlikely]] {
            grow(count);
        }
        T* values = values_.get() + size_;
        size_ += count;
        return values;
    }
    /// Removes all elements. The capacity stays.
    void clear() { size_ = 0; }
    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    const T* data() const { return values_.get(); }
    std::span<const T> values() const { return {values_.get(), size_}; }

  private:
    void grow(std::size_t count) {
        constexpr std::size_t first_capacity = 256;
        const std::size_t capacity = std::max({first_capacity, 2 * capacity_, size_ + count});
        auto values = std::make_unique_for_overwrite<T[]>(capacity);
        if (size_ > 0) {
            std::memcpy(static_cast<void*>(values.get()), values_.get(), size_ * sizeof(T));
        }
        values_ = std::move(values);
        capacity_ = capacity;
    }

    std::unique_ptr<T[]> values_;
    std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace pxpl5::gp
