// From a volume's scalar type, known at run time, to a C++ type.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>

#include "gp_firmware/volume/slice.hpp"

namespace pxpl5::gp {

/// Calls work(T{}) with the C++ type of `type`.
template <class Work>
void with_scalar(Scalar type, Work&& work) {
    switch (type) {
        case Scalar::uint8:
            return work(std::uint8_t{});
        case Scalar::int16:
            return work(std::int16_t{});
        case Scalar::uint16:
            return work(std::uint16_t{});
        case Scalar::float32:
            return work(float{});
    }
}

/// Returns the bytes as values of T. The bytes are aligned for T, because an allocator returned
/// them.
template <class T>
const T* typed(std::span<const std::byte> values) {
    assert(reinterpret_cast<std::uintptr_t>(values.data()) % alignof(T) == 0);
    return reinterpret_cast<const T*>(values.data());
}

}  // namespace pxpl5::gp
