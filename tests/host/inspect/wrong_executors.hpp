// Executors with a planted mistake, for tests of what must find it.
#pragma once

#include <memory>

#include "host/inspect/diff/executor_diff.hpp"
#include "host/inspect/replay/scoped_reference.hpp"
#include "isa/contract/triangle_shape.hpp"
#include "renderer_firmware/fast/fast.hpp"

namespace pxpl5::test {

/// The fast executor, instruction by instruction, with a mistake behind some of them.
class WrongExecutor final : public isa::Executor {
  public:
    /// Called behind each instruction.
    using Mistake = std::function<void(isa::Instruction, isa::Coefficients, isa::Executor&)>;
    explicit WrongExecutor(Mistake mistake) : mistake_(std::move(mistake)) {
        fast_.set_readout([this](std::span<const std::uint32_t> words) { read_out(words); });
    }
    void execute(isa::Instruction in, isa::Coefficients coefficients) override {
        fast_.execute(in, coefficients);
        mistake_(in, coefficients, fast_);
    }
    bool any_enabled() const override { return fast_.any_enabled(); }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override {
        return fast_.field(x, y, a, n);
    }
    bool enabled(int x, int y) const override { return fast_.enabled(x, y); }
    bool carry(int x, int y) const override { return fast_.carry(x, y); }
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override {
        return fast_.backing_block(x, y, block);
    }

  private:
    renderer::fast::Fast fast_;
    Mistake mistake_;
};

/// The fast executor, which runs ahead wrongly: behind a run of at least `triangles` triangles it
/// leaves bit 3 of z inverted where the last one drew. One by one they are right.
class WrongAhead final : public isa::Executor {
  public:
    explicit WrongAhead(std::size_t triangles) : triangles_(triangles) {
        fast_.set_readout([this](std::span<const std::uint32_t> words) { read_out(words); });
    }
    void execute(isa::Instruction in, isa::Coefficients coefficients) override {
        fast_.execute(in, coefficients);
    }
    isa::Taken execute_ahead(std::span<const std::uint32_t> words) override {
        const isa::Taken taken = fast_.execute_ahead(words);
        if (taken.instructions >= 10 * triangles_ && words.size() >= isa::triangle::word_count &&
            isa::triangle::matches(words.data())) {
            fast_.execute({isa::Op::not_mem, {11, 0, 1}}, {});
        }
        return taken;
    }
    bool any_enabled() const override { return fast_.any_enabled(); }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override {
        return fast_.field(x, y, a, n);
    }
    bool enabled(int x, int y) const override { return fast_.enabled(x, y); }
    bool carry(int x, int y) const override { return fast_.carry(x, y); }
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override {
        return fast_.backing_block(x, y, block);
    }

  private:
    std::size_t triangles_;
    renderer::fast::Fast fast_;
};

inline host::inspect::MakeExecutor reference_maker() {
    return [] { return std::make_unique<host::inspect::ScopedReference>(); };
}
inline host::inspect::MakeExecutor wrong_maker(const WrongExecutor::Mistake& mistake) {
    return [mistake] { return std::make_unique<WrongExecutor>(mistake); };
}
inline host::inspect::MakeExecutor wrong_ahead_maker(std::size_t triangles) {
    return [triangles] { return std::make_unique<WrongAhead>(triangles); };
}

}  // namespace pxpl5::test
