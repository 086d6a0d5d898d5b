// The handler table of every vector target, and the choice among them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/handlers.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles what follows once per target.
#include <hwy/highway.h>

#include <cstdlib>
#include <stdexcept>

#include "renderer_firmware/fast/handlers.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

// In enable.cpp, tree.cpp, memory.cpp, arithmetic.cpp, backing.cpp and control.cpp. A row without
// a handler does not link, unless the controller runs it.
#define PXPL5_OP(id, ...)                                                \
    void id(hal::Board& board, BlockRange range, isa::Operands operands, \
            isa::Coefficients coefficients);
#include "isa/instructions.def"
#undef PXPL5_OP

// In triangle.cpp.
isa::Taken run_triangles(hal::Board& board, const std::uint32_t* words, std::size_t word_count);

HandlerTable make_handlers() {
    HandlerTable table{};
#define PXPL5_OP(id, ...)                                  \
    if constexpr (!isa::info(isa::Op::id).is_control()) {  \
        table[static_cast<std::size_t>(isa::Op::id)] = id; \
    }
#include "isa/instructions.def"
#undef PXPL5_OP
    return table;
}

const Backend& compiled_backend() {
    static const Backend code{make_handlers(), run_triangles};
    return code;
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::renderer::fast {

HWY_EXPORT(compiled_backend);

namespace {

struct TargetRow {
    Target target;
    std::string_view name;
    std::int64_t highway;  ///< Highway's bits for it.
};
constexpr TargetRow target_rows[] = {
    {Target::sse4, "sse4", HWY_SSE4},
    {Target::avx2, "avx2", HWY_AVX2},
    {Target::avx512, "avx512", HWY_AVX3},
};

/// Highway's bits that were compiled and that this machine has.
std::int64_t usable_bits() {
    return HWY_TARGETS & hwy::SupportedTargets();
}

std::string available_names() {
    std::string names = "best";
    for (const Target target : available_targets()) {
        names += ", " + std::string(target_name(target));
    }
    return names;
}

[[noreturn]] void refuse(std::string_view name) {
    throw std::invalid_argument("vector target \"" + std::string(name) +
                                "\" is not available here; PXPL5_TARGET may be " +
                                available_names());
}

}  // namespace

std::string_view target_name(Target target) {
    for (const TargetRow& row : target_rows) {
        if (row.target == target) {
            return row.name;
        }
    }
    return "best";
}

std::vector<Target> available_targets() {
    std::vector<Target> targets;
    for (const TargetRow& row : target_rows) {
        if ((row.highway & usable_bits()) != 0) {
            targets.push_back(row.target);
        }
    }
    return targets;
}

Target target_from_environment() {
    const char* value = std::getenv("PXPL5_TARGET");
    const std::string_view name = value == nullptr ? "" : value;
    if (name.empty() || name == "best") {
        return Target::best;
    }
    for (const Target target : available_targets()) {
        if (name == target_name(target)) {
            return target;
        }
    }
    refuse(name);
}

const Backend& backend(Target target) {
    std::int64_t bits = usable_bits();
    for (const TargetRow& row : target_rows) {
        bits = row.target == target ? bits & row.highway : bits;
    }
    if (bits == 0) {
        refuse(target_name(target));
    }
    // Highway's own choice is global to the process; this one belongs to the caller.
    hwy::ChosenTarget chosen;
    chosen.Update(bits);
    return HWY_DISPATCH_TABLE(compiled_backend)[chosen.GetIndex()]();
}

}  // namespace pxpl5::renderer::fast
#endif  // HWY_ONCE
