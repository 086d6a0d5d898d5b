// Growing: a vector whose new elements are not cleared first, and whose room stays.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

namespace pxpl5::gp {

/// Plain values that are written once, in order, frame after frame.
template <typename T>
class Growing {
    static_assert(std::is_trivially_copyable_v<T>);

  public:
    /// Room for `count` more; the caller writes all of them.
    T* append(std::size_t count) {
        if (capacity_ - size_ < count) [[unlikely]] {
            grow(count);
        }
        T* values = values_.get() + size_;
        size_ += count;
        return values;
    }
    /// Empty; the room is kept.
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
