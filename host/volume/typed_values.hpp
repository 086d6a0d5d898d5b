// A volume's values in their own type.
#pragma once

#include <cassert>
#include <cstdint>
#include <span>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Calls work(std::span<const T>) with the volume's values. They are aligned for T, as all that an
/// allocator returns.
template <class Work>
void with_values(const Volume& volume, Work&& work) {
    const auto as = [&]<class T>(T) {
        assert(reinterpret_cast<std::uintptr_t>(volume.values.data()) % alignof(T) == 0);
        work(std::span(reinterpret_cast<const T*>(volume.values.data()),
                       volume.values.size() / sizeof(T)));
    };
    switch (volume.type) {
        case Scalar::uint8:
            return as(std::uint8_t{});
        case Scalar::int16:
            return as(std::int16_t{});
        case Scalar::uint16:
            return as(std::uint16_t{});
        case Scalar::float32:
            return as(float{});
    }
}

}  // namespace pxpl5::host
