// Selects among the handler tables of the vector targets.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "renderer_firmware/fast/handlers.cpp"
#include <hwy/foreach_target.h>
// Behind foreach_target.h, which compiles the rest once per target.
#include <hwy/highway.h>

#include "isa/contract/vector_target.hpp"
#include "renderer_firmware/fast/handlers.hpp"

HWY_BEFORE_NAMESPACE();
namespace pxpl5::renderer::fast::HWY_NAMESPACE {

// Defined in enable.cpp, tree.cpp, memory.cpp, arithmetic.cpp, backing.cpp and control.cpp. A row
// without a handler does not link, unless the controller runs the row.
#define PXPL5_OP(id, ...)                                                \
    void id(hal::Board& board, BlockRange range, isa::Operands operands, \
            isa::Coefficients coefficients);
#include "isa/instructions.def"
#undef PXPL5_OP

// Defined in triangle.cpp.
isa::Taken run_triangles(hal::Board& board, const std::uint32_t* words, std::size_t word_count);

// Defined in fused.cpp.
std::span<const Fused> fused_programs();

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
    static const Backend code{make_handlers(), run_triangles, fused_programs()};
    return code;
}

}  // namespace pxpl5::renderer::fast::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace pxpl5::renderer::fast {

const Backend& backend(Target target) {
    return PXPL5_PER_TARGET(compiled_backend)[isa::resolve(target)]();
}

}  // namespace pxpl5::renderer::fast
#endif  // HWY_ONCE
