// The reference executor made quick for whole frames: a triangle runs on the pixels of its box.
//
// Once a triangle has run, no pixel outside of the box in which all its edges can be 0 or more is
// enabled. So, of ten instructions on 16,384 pixels, those on the box are left, and the enables
// that the triangle before it has left in its own box are cleared. Everything else runs on all
// pixels. Nothing is shared with the fast executor, neither its boxes nor its recognition of
// triangles.
#pragma once

#include "isa/reference/reference.hpp"

namespace pxpl5::host::inspect {

/// A box that holds every pixel which passes the three sign tests of the triangle program at
/// `words` (isa/contract/triangle_shape.hpp matches() it). Its width is 0 if there is none.
isa::reference::Window triangle_box(const std::uint32_t* words);

/// A crafted region could keep the reference busy for hours. The work of an instruction is its
/// modelled cycles times the pixels that it runs on. The limit is about 10 minutes of work, and 120
/// times that of the largest region measured: four surfaces of the pelvis with four lights and 16
/// samples, all in one region.
inline constexpr std::uint64_t max_reference_work = std::uint64_t{1} << 41;

class ScopedReference final : public isa::Executor {
  public:
    /// most_work  The work after which execute() and execute_ahead() throw RequestError (bad_data).
    explicit ScopedReference(std::uint64_t most_work = max_reference_work);

    void execute(isa::Instruction in, isa::Coefficients coefficients) override;
    /// Runs the triangles at the head of `words`.
    isa::Taken execute_ahead(std::span<const std::uint32_t> words) override;

    bool any_enabled() const override { return reference_.any_enabled(); }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override {
        return reference_.field(x, y, a, n);
    }
    bool enabled(int x, int y) const override { return reference_.enabled(x, y); }
    bool carry(int x, int y) const override { return reference_.carry(x, y); }
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override {
        return reference_.backing_block(x, y, block);
    }

    struct State {
        isa::reference::Reference::State pixels;
        isa::reference::Window enabled;
        std::uint64_t work = 0;
    };
    State save() const { return {reference_.save(), enabled_, work_}; }
    void restore(const State& state);

  private:
    void run_triangle(const std::uint32_t* words, isa::Taken& taken);
    void run(isa::Instruction in, isa::Coefficients coefficients,
             const isa::reference::Window& scope);

    isa::reference::Reference reference_;
    isa::reference::Window enabled_;  ///< No pixel outside of it is enabled.
    std::uint64_t work_ = 0, most_work_;
};
static_assert(isa::Restorable<ScopedReference>);

}  // namespace pxpl5::host::inspect
