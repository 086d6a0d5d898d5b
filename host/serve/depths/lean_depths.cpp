#include "host/serve/depths/lean_depths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "host/serve/depths/depth_word.hpp"
#include "host/serve/depths/lean_seams.hpp"
#include "isa/contract/depth.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr std::uint32_t nothing = UINT32_MAX;  ///< Farther than every depth.

std::size_t index_of(int value) {
    return static_cast<std::size_t>(value);
}

/// The nearest depth of some pixels.
void take_nearer(std::uint32_t& least, std::uint32_t word) {
    if (shows_surface(word)) {
        least = std::min(least, depth_of(word));
    }
}

/// The nearest depth of the surfaces in each cell, with a border of empty cells around.
std::vector<std::uint32_t> nearest_of_cells(int width, int height, int columns, int rows,
                                            std::span<const std::uint32_t> depths) {
    const std::size_t across = index_of(columns) + 1;
    std::vector<std::uint32_t> nearest(across * (index_of(rows) + 1), nothing);
    const std::uint32_t* word = depths.data();
    for (int y = 0; y < height; ++y) {
        std::uint32_t* const cells = &nearest[index_of(y / lean_cell_px + 1) * across + 1];
        for (int x = 0; x < width; ++x) {
            take_nearer(cells[x / lean_cell_px], *word++);
        }
    }
    return nearest;
}

/// The nearest depth in the four pixels that touch the corner.
std::uint32_t nearest_at(int width, int height, int column, int row,
                         std::span<const std::uint32_t> depths) {
    std::uint32_t least = nothing;
    for (int y = std::max(0, row * lean_cell_px - 1); y <= std::min(height - 1, row * lean_cell_px);
         ++y) {
        for (int x = std::max(0, column * lean_cell_px - 1);
             x <= std::min(width - 1, column * lean_cell_px); ++x) {
            take_nearer(least, depths[index_of(y) * index_of(width) + index_of(x)]);
        }
    }
    return least;
}

std::vector<std::uint8_t> mask_of(int width, int height, std::span<const std::uint32_t> depths) {
    const std::size_t row_bytes = mask_row_bytes(width);
    std::vector<std::uint8_t> mask(row_bytes * index_of(height));
    const std::uint32_t* word = depths.data();
    for (int y = 0; y < height; ++y) {
        std::uint8_t* const row = &mask[index_of(y) * row_bytes];
        for (int x = 0; x < width; ++x) {
            const unsigned bit = shows_surface(*word++) ? 1U : 0U;
            row[x / 8] = static_cast<std::uint8_t>(row[x / 8] | bit << (x % 8));
        }
    }
    return mask;
}

}  // namespace

std::array<std::uint16_t, 4> LeanDepths::corners_of(std::uint32_t cell) const {
    const std::size_t corner = cell + cell / (index_of(columns) - 1);
    const std::size_t below = corner + index_of(columns);
    return {corners[corner], corners[corner + 1], corners[below], corners[below + 1]};
}

std::uint16_t lean_of(std::uint32_t depth) {
    const double share = (isa::ndc_of_depth(depth) + 1) / 2;
    return static_cast<std::uint16_t>(
        1 + std::clamp(static_cast<int>(share * max_lean), 0, max_lean - 1));
}

std::size_t mask_row_bytes(int width) {
    return (index_of(width) + 7) / 8;
}

LeanDepths lean_depths(int width, int height, std::span<const std::uint32_t> depths) {
    if (depths.size() != index_of(width) * index_of(height)) {
        throw std::invalid_argument(
            fmt::format("lean depths: {} depths, but a picture of {} x {} pixels has {}. Pass the "
                        "depths of one view",
                        depths.size(), width, height, index_of(width) * index_of(height)));
    }
    LeanDepths lean;
    lean.width = width;
    lean.height = height;
    lean.columns = (width + lean_cell_px - 1) / lean_cell_px + 1;
    lean.rows = (height + lean_cell_px - 1) / lean_cell_px + 1;
    lean.mask = mask_of(width, height, depths);
    const std::vector<std::uint32_t> cells =
        nearest_of_cells(width, height, lean.columns, lean.rows, depths);
    const std::size_t across = index_of(lean.columns) + 1;
    lean.corners.reserve(index_of(lean.columns) * index_of(lean.rows));
    for (int row = 0; row < lean.rows; ++row) {
        for (int column = 0; column < lean.columns; ++column) {
            // The four cells around the corner: up and left of it, and so on.
            const std::uint32_t* const around = &cells[index_of(row) * across + index_of(column)];
            const std::uint32_t in_cells =
                std::min({around[0], around[1], around[across], around[across + 1]});
            const std::uint32_t touching =
                in_cells == nothing ? nothing : nearest_at(width, height, column, row, depths);
            const std::uint32_t nearest = touching != nothing ? touching : in_cells;
            lean.corners.push_back(nearest == nothing ? std::uint16_t{0} : lean_of(nearest));
        }
    }
    lean.seams = find_seams(lean, depths);
    return lean;
}

}  // namespace pxpl5::host::serve
