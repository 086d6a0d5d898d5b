// The reference executor: defines every row, pixel by pixel and bit by bit. The code is slow and
// obvious.
#pragma once

#include <memory>

#include "isa/executor.hpp"
#include "isa/reference/pixel_array.hpp"

namespace pxpl5::isa::reference {

/// One handler per row that acts on pixels; in enable.cpp, tree.cpp, memory.cpp, arithmetic.cpp,
/// backing.cpp and control.cpp. A row without a handler does not link.
#define PXPL5_OP(id, ...) void id(PixelArray& pixels, Operands operands, Coefficients coefficients);
#include "isa/instructions.def"
#undef PXPL5_OP

class Reference final : public Executor {
  public:
    /// Emulates only the pixels of `window`; the others read as 0 and disabled. One instruction
    /// takes about 1 ms on a whole region, and some microseconds on a window of 16 x 8.
    explicit Reference(Window window = {});

    void execute(Instruction in, Coefficients coefficients) override;
    bool any_enabled() const override;
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override;
    bool enabled(int x, int y) const override;
    bool carry(int x, int y) const override;
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override;

    const Window& window() const { return pixels_.window; }

    /// From now on instructions act only on the pixels of `scope`, a part of the window. The other
    /// pixels do not change, and PIXELSTOFB sends 0 for them.
    void set_scope(const Window& scope);

    using State = std::vector<Pixel>;
    State save() const { return pixels_.pixels; }
    /// Restores a state that an executor of the same window saved.
    void restore(const State& state);

    /// Sets field m[a : a+n) of pixel (x, y) in the window, for tests and tools that start from a
    /// given state.
    void set_field(int x, int y, std::uint32_t a, std::uint32_t n, std::uint64_t value);

  private:
    PixelArray pixels_;
};
static_assert(Restorable<Reference>);

}  // namespace pxpl5::isa::reference
