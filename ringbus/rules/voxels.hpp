// Voxels in messages and in memory. Plain, for every stage.
#pragma once

#include <cstddef>

#include "generated/vocabulary.hpp"

namespace pxpl5 {

/// Bytes of one voxel.
constexpr std::size_t size_bytes(Scalar type) {
    return type == Scalar::uint8 ? 1 : type == Scalar::float32 ? 4 : 2;
}

}  // namespace pxpl5
