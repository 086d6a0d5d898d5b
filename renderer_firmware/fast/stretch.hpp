// A straight-line stretch of a program. It runs on one group of blocks after another, so that the
// memory of a group stays in the first-level cache.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer_firmware/fast/handlers.hpp"

namespace pxpl5::renderer::fast {

class Stretch {
  public:
    /// `code` must outlive the stretch.
    explicit Stretch(const Backend& code);

    /// Takes the stretch at the beginning of `words`, which must outlive its use. The stretch ends
    /// at a control row, at a row that uses the port, and at a possible triangle.
    isa::Taken gather(std::span<const std::uint32_t> words);

    void run(hal::Board& board) const;

  private:
    /// One instruction, or some words that run as one step.
    struct Step {
        const Fused* fused;  ///< Null: `handler` runs the instruction.
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

    // A tile without enabled pixels does not change until an instruction enables a pixel: all
    // pixels, or those with a bit of memory set.
    bool wakes_all_ = false;
    std::array<std::uint32_t, hal::column_count> wake_bits_{};  ///< Indexed by column.
};

}  // namespace pxpl5::renderer::fast
