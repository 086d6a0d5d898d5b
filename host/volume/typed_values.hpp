// A volume's values in their own type.
#pragma once

#include <cassert>
#include <cstdint>
#include <span>

#include "host/volume/scalar_types.hpp"
#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Calls work(std::span<const T>) with the volume's values. They are aligned for T, as all that an
/// allocator returns.
template <class Work>
void with_values(const Volume& volume, Work&& work) {
    with_scalar(volume.type, [&]<typename T>(T*) {
        assert(reinterpret_cast<std::uintptr_t>(volume.values.data()) % alignof(T) == 0);
        work(std::span(reinterpret_cast<const T*>(volume.values.data()),
                       volume.values.size() / sizeof(T)));
    });
}

}  // namespace pxpl5::host
