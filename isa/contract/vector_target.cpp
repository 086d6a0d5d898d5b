#include "isa/contract/vector_target.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace pxpl5::isa {

namespace {

/// True if this computer has all instructions that Highway's code for the target may use.
bool has(VectorTarget target) {
#ifdef __x86_64__
    switch (target) {
        case VectorTarget::best:
        case VectorTarget::sse4:
            return __builtin_cpu_supports("sse4.2") != 0 && __builtin_cpu_supports("pclmul") != 0 &&
                   __builtin_cpu_supports("aes") != 0;
        case VectorTarget::avx2:
            return has(VectorTarget::sse4) && __builtin_cpu_supports("avx2") != 0 &&
                   __builtin_cpu_supports("fma") != 0 && __builtin_cpu_supports("bmi") != 0 &&
                   __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_supports("lzcnt") != 0 &&
                   __builtin_cpu_supports("f16c") != 0;
        case VectorTarget::avx512:
            return has(VectorTarget::avx2) && __builtin_cpu_supports("avx512f") != 0 &&
                   __builtin_cpu_supports("avx512vl") != 0 &&
                   __builtin_cpu_supports("avx512dq") != 0 &&
                   __builtin_cpu_supports("avx512bw") != 0 &&
                   __builtin_cpu_supports("avx512cd") != 0;
    }
    return false;
#else
    return target == VectorTarget::best;
#endif
}

[[noreturn]] void refuse(std::string_view name) {
    std::string available = "best";
    for (const VectorTarget target : available_targets()) {
        available += ", " + std::string(enum_name(target));
    }
    throw std::invalid_argument(fmt::format(
        "vector target \"{}\" is not available on this computer; PXPL5_TARGET may be {}", name,
        available));
}

}  // namespace

std::vector<VectorTarget> available_targets() {
    std::vector<VectorTarget> targets;
    for (const VectorTarget target :
         {VectorTarget::sse4, VectorTarget::avx2, VectorTarget::avx512}) {
        if (has(target)) {
            targets.push_back(target);
        }
    }
    return targets;
}

VectorTarget target_from_environment() {
    const char* value = std::getenv("PXPL5_TARGET");
    const std::string_view name = value == nullptr ? "" : value;
    if (name.empty() || name == enum_name(VectorTarget::best)) {
        return VectorTarget::best;
    }
    for (const VectorTarget target : available_targets()) {
        if (name == enum_name(target)) {
            return target;
        }
    }
    refuse(name);
}

VectorTarget resolve(VectorTarget target) {
    if (!has(target)) {
        refuse(enum_name(target));
    }
    if (target != VectorTarget::best) {
        return target;
    }
    // Processors other than x86 have one unnamed target, which is stored for all three names.
    const std::vector<VectorTarget> there = available_targets();
    return there.empty() ? VectorTarget::sse4 : there.back();
}

VectorTarget process_target() {
    static const VectorTarget target = resolve(target_from_environment());
    return target;
}

}  // namespace pxpl5::isa
