// The fast executor: the instructions of isa/instructions.def on bit columns, many pixels at a
// time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "renderer_firmware/fast/stretch.hpp"

namespace pxpl5::renderer::fast {

class Fast final : public isa::Executor {
  public:
    /// Pixels start cleared and disabled.
    /// Throws std::invalid_argument if this machine lacks `target`.
    explicit Fast(Target target = isa::process_target()) : Fast(backend(target)) {}

    /// With the handlers of `code`: for tests that plant a wrong one.
    explicit Fast(const Backend& code);

    /// Back to the state of a new executor. What a region leaves must not reach the next one, or
    /// the picture would depend on which Renderer draws which region.
    void reset();

    /// The same, but for the backing store, which keeps a picture's sums from pass to pass.
    void reset_pixels();

    /// All that instructions act on, 460 KB and 64 KB a backing-store block in use. What the port
    /// held, and where, is no part of it: PIXELSTOFB writes all of it before anybody reads.
    struct State {
        std::unique_ptr<const hal::PixelArray> pixels;
        std::vector<std::pair<std::uint32_t, hal::BackingStore::Words>> blocks;
        std::size_t bytes() const;
    };
    State save() const;
    void restore(const State& state);

    /// From now on PIXELSTOFB writes its words to `rows`, row by row (index y * 128 + x), before
    /// the readout sink gets to see them there. `rows` holds a region's words and outlives its use;
    /// an empty one means memory of the executor's own.
    void read_out_into(std::span<std::uint32_t> rows) { board_->port.aim(rows); }

    /// For tools that look at all pixels at once.
    const hal::PixelArray& pixels() const { return board_->pixels; }

    void execute(isa::Instruction in, isa::Coefficients coefficients) override;

    /// Runs triangles fused, and other straight-line stretches block group by block group.
    isa::Taken execute_ahead(std::span<const std::uint32_t> words) override;

    bool any_enabled() const override { return board_->pixels.any_enabled(); }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override;
    bool enabled(int x, int y) const override;
    bool carry(int x, int y) const override;
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override;

  private:
    const Backend& code_;
    std::unique_ptr<hal::Board> board_;
    Stretch stretch_;  ///< The one being run.
};
static_assert(isa::Restorable<Fast>);

}  // namespace pxpl5::renderer::fast
