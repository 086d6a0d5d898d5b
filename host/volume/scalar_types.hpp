// From a volume's scalar type, known at run time, to a C++ type.
#pragma once

#include <cstdint>

#include "host/volume/volume.hpp"

namespace pxpl5::host {

/// Calls work(T*) with a null pointer of the C++ type of `type`, and returns its result.
template <typename Work>
auto with_scalar(Scalar type, Work&& work) {
    switch (type) {
        case Scalar::uint8:
            return work(static_cast<std::uint8_t*>(nullptr));
        case Scalar::int16:
            return work(static_cast<std::int16_t*>(nullptr));
        case Scalar::uint16:
            return work(static_cast<std::uint16_t*>(nullptr));
        case Scalar::float32:
            break;
    }
    return work(static_cast<float*>(nullptr));
}

}  // namespace pxpl5::host
