// Runs two executors side by side and compares the pixels of a window after each instruction.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "isa/disassemble.hpp"
#include "isa/executor.hpp"
#include "isa/reference/reference.hpp"

namespace pxpl5::test {

/// Thrown at the first difference. The text names instruction, pixel, field and both values.
struct Divergence : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// An executor that runs each instruction on `trusted` and on `tested` and throws Divergence if
/// they differ. Run it with isa::run(). It uses the OR of the enables of `tested`, because
/// `trusted` may emulate only a window.
class Lockstep final : public isa::Executor {
  public:
    Lockstep(isa::reference::Reference& trusted, isa::Executor& tested)
        : trusted_(trusted), tested_(tested) {
        trusted_.set_readout(
            [this](auto pixels) { trusted_pixels_.assign(pixels.begin(), pixels.end()); });
        tested_.set_readout(
            [this](auto pixels) { tested_pixels_.assign(pixels.begin(), pixels.end()); });
    }

    void execute(isa::Instruction in, isa::Coefficients coefficients) override {
        trusted_.execute(in, coefficients);
        tested_.execute(in, coefficients);
        ++executed_;
        compare([&] { return isa::disassemble(in, coefficients); }, in);
    }

    bool any_enabled() const override { return tested_.any_enabled(); }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override {
        return tested_.field(x, y, a, n);
    }
    bool enabled(int x, int y) const override { return tested_.enabled(x, y); }
    bool carry(int x, int y) const override { return tested_.carry(x, y); }
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override {
        return tested_.backing_block(x, y, block);
    }

    /// Compares all state and all blocks; `context` is part of the message. Throws Divergence.
    void compare_all(const std::string& context) {
        const auto text = [&] { return context; };
        compare(text, {});
        for (std::uint32_t block = 0; block < isa::backing_blocks; ++block) {
            each_pixel([&](int x, int y) { compare_block(text, x, y, block); });
        }
    }

  private:
    template <typename Action>
    void each_pixel(Action action) const {
        const isa::reference::Window& w = trusted_.window();
        for (int y = w.y0; y < w.y0 + w.height; ++y) {
            for (int x = w.x0; x < w.x0 + w.width; ++x) {
                action(x, y);
            }
        }
    }

    /// `text` is called for the message only.
    template <typename Text>
    void compare(const Text& text, isa::Instruction in) const {
        const isa::OpInfo& row = info(in.op);
        each_pixel([&](int x, int y) {
            const auto same_state = [&](const char* what, std::uint64_t expected,
                                        std::uint64_t found) {
                if (expected != found) {
                    fail(text(), x, y, what, expected, found);
                }
            };
            same_state("enable", trusted_.enabled(x, y), tested_.enabled(x, y));
            same_state("carry", trusted_.carry(x, y), tested_.carry(x, y));
            for (std::uint32_t a = 0; a < isa::memory_bits; a += 52) {
                const std::uint64_t expected = trusted_.field(x, y, a, 52);
                const std::uint64_t found = tested_.field(x, y, a, 52);
                if (expected != found) {
                    fail(text(), x, y, fmt::format("m[{}:52]", a), expected, found);
                }
            }
            if (row.b_role == isa::Role::block) {
                compare_block(text, x, y, in.operands.b);
            }
            if (in.op == isa::Op::pixels_to_fb) {
                const auto at = static_cast<std::size_t>(y * region_px + x);
                same_state("readout", trusted_pixels_.at(at), tested_pixels_.at(at));
            }
        });
    }

    template <typename Text>
    void compare_block(const Text& text, int x, int y, std::uint32_t block) const {
        const std::uint32_t expected = trusted_.backing_block(x, y, block);
        const std::uint32_t found = tested_.backing_block(x, y, block);
        if (expected != found) {
            fail(text(), x, y, "backing store", expected, found);
        }
    }

    [[noreturn]] void fail(const std::string& text, int x, int y, std::string_view what,
                           std::uint64_t expected, std::uint64_t found) const {
        throw Divergence(fmt::format(
            "instruction {} ({}), pixel ({}, {}): {} is 0x{:x}, the reference has 0x{:x}",
            executed_, text, x, y, what, found, expected));
    }

    isa::reference::Reference& trusted_;
    isa::Executor& tested_;
    std::vector<std::uint32_t> trusted_pixels_, tested_pixels_;
    std::size_t executed_ = 0;
};

}  // namespace pxpl5::test
