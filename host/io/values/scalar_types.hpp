// A volume's values as C++ types.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

#include "host/volume/scalar_types.hpp"

namespace pxpl5::host::io {

/// Bytes as values. They begin at whole values of buffers from operator new, which aligns for all.
template <typename T>
std::span<const T> typed(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
}
template <typename T>
std::span<T> typed(std::span<std::byte> bytes) {
    return {reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T)};
}

/// The nearest value of T; halves go up, so that the result does not depend on a rounding mode.
template <typename T>
T nearest(double value) {
    if constexpr (std::is_integral_v<T>) {
        const double low = std::numeric_limits<T>::min(), high = std::numeric_limits<T>::max();
        return static_cast<T>(std::clamp(std::floor(value + 0.5), low, high));
    } else {
        return static_cast<T>(value);
    }
}

}  // namespace pxpl5::host::io
