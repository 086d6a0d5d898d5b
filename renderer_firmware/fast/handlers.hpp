// The handlers of the fast executor, one per row of instructions.def, once per vector target.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "isa/contract/vector_target.hpp"
#include "isa/executor.hpp"
#include "renderer_firmware/hal/board.hpp"

namespace pxpl5::renderer::fast {

/// The blocks of pixels that one call acts on: first .. end-1.
struct BlockRange {
    std::size_t first = 0;
    std::size_t end = hal::block_count;
};

/// Runs one instruction on the pixels of some blocks.
using Handler = void (*)(hal::Board& board, BlockRange range, isa::Operands operands,
                         isa::Coefficients coefficients);

/// Handlers by row; null for control rows.
using HandlerTable = std::array<Handler, isa::op_count>;

/// The extent of a run of triangle programs (isa/contract/triangle_shape.hpp).
using TriangleRun = isa::Taken (*)(hal::Board& board, const std::uint32_t* words,
                                   std::size_t word_count);

/// A tile of pixels.
struct Tile {
    std::uint32_t* first;  ///< Word 0 of the first pixel; word k is k * block_pixels behind.
    std::size_t index;     ///< Storage index of the first pixel (pixel_index()).
};
/// Adjacent tiles of one block.
using Tiles = std::span<const Tile>;

/// A stretch of the region programs' texts that runs as one step.
struct Fused {
    /// Returns the number of words if `words` begins with the stretch, else 0.
    std::size_t (*match)(std::span<const std::uint32_t> words);
    /// Runs the stretch at `words` on some tiles.
    void (*run)(hal::Board& board, Tiles tiles, std::span<const std::uint32_t> words);
};

/// The code of one vector target.
struct Backend {
    HandlerTable handlers;
    TriangleRun triangles;  ///< Runs the triangles at the beginning of `words`, fused.
    std::span<const Fused> fused;
};

using Target = VectorTarget;

/// Returns the code of `target`.
/// Throws std::invalid_argument if this computer does not have `target`.
const Backend& backend(Target target);

}  // namespace pxpl5::renderer::fast
