#include "isa/reference/reference.hpp"

#include <algorithm>

#include "isa/reference/bits.hpp"

namespace pxpl5::isa::reference {
namespace {

using Handler = void (*)(PixelArray&, Operands, Coefficients);

/// Returns the handler of row `index`, or none for control rows, which the sequencer runs. The
/// discarded branch makes a handler of a control row unnecessary.
template <std::size_t index>
constexpr Handler handler_if_pixels([[maybe_unused]] auto name_handler) {
    if constexpr (op_table[index].is_control()) {
        return nullptr;
    } else {
        return name_handler(std::integral_constant<std::size_t, index>{});
    }
}

constexpr std::array<Handler, op_count> handlers = {
#define PXPL5_OP(id, ...)                                \
    handler_if_pixels<static_cast<std::size_t>(Op::id)>( \
        [](auto) { return static_cast<Handler>(&reference::id); }),
#include "isa/instructions.def"
#undef PXPL5_OP
};

}  // namespace

Reference::Reference(Window window) : pixels_(window) {
    pixels_.readout = [this](std::span<const std::uint32_t> words) { read_out(words); };
}

void Reference::execute(Instruction in, Coefficients coefficients) {
    const Handler handler = handlers[static_cast<std::size_t>(in.op)];
    assert(handler != nullptr && "control rows are the sequencer's");
    handler(pixels_, in.operands, coefficients);
}

void Reference::set_scope(const Window& scope) {
    [[maybe_unused]] const Window& w = pixels_.window;
    assert(scope.x0 >= w.x0 && scope.x0 + scope.width <= w.x0 + w.width);
    assert(scope.y0 >= w.y0 && scope.y0 + scope.height <= w.y0 + w.height);
    pixels_.scope = scope;
}

bool Reference::any_enabled() const {
    return std::ranges::any_of(pixels_.pixels, &Pixel::enable);
}

std::uint64_t Reference::field(int x, int y, std::uint32_t a, std::uint32_t n) const {
    assert(n >= 1 && n <= 64 && a + n <= memory_bits);
    if (!pixels_.window.contains(x, y)) {
        return 0;
    }
    const Pixel& pixel = pixels_.at(x, y);
    std::uint64_t value = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        value |= static_cast<std::uint64_t>(pixel.m[a + i]) << i;
    }
    return value;
}

bool Reference::enabled(int x, int y) const {
    return pixels_.window.contains(x, y) && pixels_.at(x, y).enable;
}

bool Reference::carry(int x, int y) const {
    return pixels_.window.contains(x, y) && pixels_.at(x, y).carry;
}

std::uint32_t Reference::backing_block(int x, int y, std::uint32_t block) const {
    assert(block < backing_blocks);
    if (!pixels_.window.contains(x, y) || pixels_.at(x, y).blocks.empty()) {
        return 0;
    }
    return pixels_.at(x, y).blocks[block];
}

void Reference::restore(const State& state) {
    assert(state.size() == pixels_.pixels.size());
    pixels_.pixels = state;
}

void Reference::set_field(int x, int y, std::uint32_t a, std::uint32_t n, std::uint64_t value) {
    assert(n >= 1 && n <= 64 && a + n <= memory_bits);
    write(pixels_.at(x, y), a, low_bits(static_cast<std::int64_t>(value), n));
}

}  // namespace pxpl5::isa::reference
