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

/// By row; null for the rows that the controller runs.
using HandlerTable = std::array<Handler, isa::op_count>;

/// What a run of triangle programs (isa/contract/triangle_shape.hpp) took.
using TriangleRun = isa::Taken (*)(hal::Board& board, const std::uint32_t* words,
                                   std::size_t word_count);

/// A tile of pixels.
struct Tile {
    std::uint32_t* first;  ///< Word 0 of its first pixel; word k lies k * block_pixels behind.
    std::size_t index;     ///< Where its first pixel is stored (pixel_index()).
};
/// Tiles of the same block side by side.
using Tiles = std::span<const Tile>;

/// A stretch of the region programs' texts that runs as one.
struct Fused {
    /// The words of it that `words` begins with; 0 if it begins with something else.
    std::size_t (*match)(std::span<const std::uint32_t> words);
    /// Runs it, as it lies at `words`, on some tiles.
    void (*run)(hal::Board& board, Tiles tiles, std::span<const std::uint32_t> words);
};

/// The same machine code interface for every vector target.
struct Backend {
    HandlerTable handlers;
    TriangleRun triangles;  ///< Runs the triangles at the head of `words`, fused.
    std::span<const Fused> fused;
};

using Target = isa::VectorTarget;

/// The code for `target`.
/// Throws std::invalid_argument if this machine lacks it.
const Backend& backend(Target target);

}  // namespace pxpl5::renderer::fast
