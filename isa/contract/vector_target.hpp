// Selects the vector instruction set (vector target) of the fast code.
//
// Highway (foreach_target.h) compiles the fast code for all targets. The process selects one at
// run time. All targets compute the same bits. The selection of Highway's library is not used: the
// library measures a clock at process start, which takes 4 ms, 54 times for the 1993 machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "generated/vocabulary.hpp"

namespace pxpl5::isa {

/// Returns the targets of this computer among sse4, avx2, avx512, narrowest first.
std::vector<VectorTarget> available_targets();

/// Returns the target that the environment variable PXPL5_TARGET names, or best if it is unset or
/// empty. Throws std::invalid_argument if this computer does not have that target.
VectorTarget target_from_environment();

/// Returns `target`, or the widest available target for best.
/// Throws std::invalid_argument if this computer does not have the target.
VectorTarget resolve(VectorTarget target);

/// Returns resolve(target_from_environment()), computed once.
VectorTarget process_target();

/// Pointers to the same code compiled for sse4, avx2 and avx512; see PXPL5_PER_TARGET.
template <typename Code>
struct PerTarget {
    std::array<Code, 3> code;

    /// `target` must be a result of resolve().
    Code operator[](VectorTarget target) const {
        return code[static_cast<std::size_t>(target) - 1];
    }
};

}  // namespace pxpl5::isa

/// Pointers to the functions of this name that foreach_target.h compiled in each target's
/// namespace. Use it behind HWY_ONCE. Processors other than x86 have one target, and so has
/// clang-tidy.
#if defined(__x86_64__) && !defined(HWY_COMPILE_ONLY_STATIC)
#define PXPL5_PER_TARGET(function)                         \
    (::pxpl5::isa::PerTarget<decltype(&N_SSE4::function)>{ \
        {&N_SSE4::function, &N_AVX2::function, &N_AVX3::function}})
#else
#define PXPL5_PER_TARGET(function)                                       \
    (::pxpl5::isa::PerTarget<decltype(&HWY_STATIC_DISPATCH(function))>{  \
        {&HWY_STATIC_DISPATCH(function), &HWY_STATIC_DISPATCH(function), \
         &HWY_STATIC_DISPATCH(function)}})
#endif

/// The function of this name for the target of the process.
#define PXPL5_DISPATCH(function) (PXPL5_PER_TARGET(function)[::pxpl5::isa::process_target()])
