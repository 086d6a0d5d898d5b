// Numbers side by side, for the inner loops: one vector register on every machine.
#pragma once

#include <cstdint>

namespace pxpl5::gp {

// GCC's vector types: each operator works lane by lane, rounds as the scalar does and is never
// fused, so results are the same on every machine.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Double2 = double __attribute__((vector_size(16)));
using Long2 = std::int64_t __attribute__((vector_size(16)));

inline Float4 all_lanes(float value) {
    return Float4{value, value, value, value};
}

}  // namespace pxpl5::gp
