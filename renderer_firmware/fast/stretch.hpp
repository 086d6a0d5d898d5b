// A straight-line stretch of a program, made ready to run on one group of blocks after another, so
// that a group's memory stays in the first-level cache.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer_firmware/fast/handlers.hpp"

namespace pxpl5::renderer::fast {

class Stretch {
  public:
    /// `code` outlives the stretch.
    explicit Stretch(const Backend& code);

    /// Takes the stretch at the head of `words`, which outlive its use: up to a row that the
    /// controller runs or that leaves through the port, and up to what may be a triangle.
    isa::Taken gather(std::span<const std::uint32_t> words);

    void run(hal::Board& board) const;

  private:
    /// Some words that run as one, or one instruction.
    struct Step {
        const Fused* fused;  ///< Null: `handler` runs it.
        std::span<const std::uint32_t> words;
        Handler handler;
        isa::Operands operands;
        isa::Coefficients coefficients;
    };

    void add_step(std::span<const std::uint32_t> words, isa::Taken& taken);
    void note_wake(isa::Instruction in);
    std::size_t find_awake(hal::PixelArray& pixels, std::size_t first_block, Tile* tiles) const;

    const Backend& code_;
    std::vector<Step> steps_;

    // A tile with no pixel enabled stays as it is until some pixel is: by an instruction that
    // enables all, or by a bit of memory.
    bool wakes_all_ = false;
    std::array<std::uint32_t, hal::column_count> wake_bits_{};  ///< By column.
};

}  // namespace pxpl5::renderer::fast
