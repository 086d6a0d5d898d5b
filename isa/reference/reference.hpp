// The reference executor: the definition of every row, pixel by pixel and bit by bit. Slow and
// obvious.
#pragma once

#include <memory>

#include "isa/executor.hpp"
#include "isa/reference/pixel_array.hpp"

namespace pxpl5::isa::reference {

/// Handlers, one per row that pixels take part in; in enable.cpp, tree.cpp, memory.cpp,
/// arithmetic.cpp, backing.cpp and control.cpp. A row without one does not link.
#define PXPL5_OP(id, ...) void id(PixelArray& pixels, Operands operands, Coefficients coefficients);
#include "isa/instructions.def"
#undef PXPL5_OP

class Reference final : public Executor {
  public:
    /// Emulates the pixels of `window` only; the others read as 0 and never enabled. A whole region
    /// costs about 1 ms per instruction, a 16 x 8 window some microseconds.
    explicit Reference(Window window = {});

    void execute(Instruction in, Coefficients coefficients) override;
    bool any_enabled() const override;
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override;
    bool enabled(int x, int y) const override;
    bool carry(int x, int y) const override;
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override;

    const Window& window() const { return pixels_.window; }

    /// From now on instructions act on the pixels of `scope` alone, a part of the window; the
    /// others keep what they have, and PIXELSTOFB sends 0 for them.
    void set_scope(const Window& scope);

    using State = std::vector<Pixel>;
    State save() const { return pixels_.pixels; }
    /// `state` was saved by an executor of the same window.
    void restore(const State& state);

    /// Sets field m[a : a+n) of pixel (x, y) in the window: for tests and tools that start from a
    /// given state.
    void set_field(int x, int y, std::uint32_t a, std::uint32_t n, std::uint64_t value);

  private:
    PixelArray pixels_;
};
static_assert(Restorable<Reference>);

}  // namespace pxpl5::isa::reference
