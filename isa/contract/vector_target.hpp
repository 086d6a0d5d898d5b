// Which of this computer's vector instructions stand in for the machine's processors.
//
// Code for all of them is compiled with Highway (foreach_target.h) and chosen at run time; all
// give the same bits. Highway's own choice is not used: its library measures a clock whenever a
// process starts, 4 ms, which a machine of 54 processes pays 54 times.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace pxpl5::isa {

/// Vector instruction sets. `best` is the widest that this computer has.
enum class VectorTarget : std::uint8_t { best, sse4, avx2, avx512 };

/// "sse4", as PXPL5_TARGET names it.
std::string_view target_name(VectorTarget target);

/// Those of sse4, avx2, avx512 that this computer has, the narrowest first.
std::vector<VectorTarget> available_targets();

/// The target named by the environment variable PXPL5_TARGET; best if it is unset or empty.
/// Throws std::invalid_argument if its value names no target that this computer has.
VectorTarget target_from_environment();

/// `target`, but the widest there is for best.
/// Throws std::invalid_argument if this computer lacks it.
VectorTarget resolve(VectorTarget target);

/// resolve(target_from_environment()), looked up once.
VectorTarget process_target();

/// The same thing compiled for sse4, avx2 and avx512; see PXPL5_PER_TARGET.
template <typename Code>
struct PerTarget {
    std::array<Code, 3> code;

    /// `target` is resolved.
    Code operator[](VectorTarget target) const {
        return code[static_cast<std::size_t>(target) - 1];
    }
};

}  // namespace pxpl5::isa

/// Behind HWY_ONCE, where foreach_target.h has compiled a function of this name in each target's
/// namespace: pointers to all of them. Other processors than x86 have one target.
#ifdef __x86_64__
#define PXPL5_PER_TARGET(function)                         \
    (::pxpl5::isa::PerTarget<decltype(&N_SSE4::function)>{ \
        {&N_SSE4::function, &N_AVX2::function, &N_AVX3::function}})
#else
#define PXPL5_PER_TARGET(function)                                       \
    (::pxpl5::isa::PerTarget<decltype(&HWY_STATIC_DISPATCH(function))>{  \
        {&HWY_STATIC_DISPATCH(function), &HWY_STATIC_DISPATCH(function), \
         &HWY_STATIC_DISPATCH(function)}})
#endif

/// The function of this name for the process's target, to be called.
#define PXPL5_DISPATCH(function) (PXPL5_PER_TARGET(function)[::pxpl5::isa::process_target()])
