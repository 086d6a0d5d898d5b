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
    /// Throws std::invalid_argument if this computer does not have `target`.
    explicit Fast(Target target = isa::process_target()) : Fast(backend(target)) {}

    /// Uses the handlers of `code`, for tests that plant a wrong handler.
    explicit Fast(const Backend& code);

    /// Restores the state of a new executor. Without a reset, the picture would depend on which
    /// Renderer draws which region.
    void reset();

    /// Like reset(), but keeps the backing store, which holds the sums of earlier passes.
    void reset_pixels();

    /// All state that instructions use: 460 KB, and 64 KB per used backing-store block. Excludes
    /// the port, because PIXELSTOFB overwrites all of the port before any read.
    struct State {
        std::unique_ptr<const hal::PixelArray> pixels;
        std::vector<std::pair<std::uint32_t, hal::BackingStore::Words>> blocks;
        std::size_t bytes() const;
    };
    State save() const;
    void restore(const State& state);

    /// From now on PIXELSTOFB writes its words to `rows`, row by row (index y * 128 + x), and then
    /// calls the readout sink. `rows` has room for a region and must outlive its use. If `rows` is
    /// empty, PIXELSTOFB writes to memory of the executor.
    void read_out_into(std::span<std::uint32_t> rows) { board_->port.aim(rows); }

    /// The pixels, for tools that read all pixels at once.
    const hal::PixelArray& pixels() const { return board_->pixels; }

    void execute(isa::Instruction in, isa::Coefficients coefficients) override;

    /// Runs fused triangles, and other straight-line stretches one block group after another.
    isa::Taken execute_ahead(std::span<const std::uint32_t> words) override;

    bool any_enabled() const override { return board_->pixels.any_enabled(); }
    std::uint64_t field(int x, int y, std::uint32_t a, std::uint32_t n) const override;
    bool enabled(int x, int y) const override;
    bool carry(int x, int y) const override;
    std::uint32_t backing_block(int x, int y, std::uint32_t block) const override;

  private:
    const Backend& code_;
    std::unique_ptr<hal::Board> board_;
    Stretch stretch_;  ///< The current stretch.
};
static_assert(isa::Restorable<Fast>);

}  // namespace pxpl5::renderer::fast
