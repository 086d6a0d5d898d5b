#include "host/serve/depths/lean_depths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "host/serve/depths/depth_word.hpp"
#include "host/serve/depths/lean_cells.hpp"
#include "host/serve/depths/lean_seams.hpp"
#include "isa/contract/depth.hpp"

namespace pxpl5::host::serve {
namespace {

std::size_t index_of(int value) {
    return static_cast<std::size_t>(value);
}

/// The nearest depth in the four pixels that touch the corner.
std::uint32_t nearest_at(int width, int height, int column, int row,
                         std::span<const std::uint32_t> depths) {
    std::uint32_t least = no_depth;
    for (int y = std::max(0, row * lean_cell_px - 1); y <= std::min(height - 1, row * lean_cell_px);
         ++y) {
        for (int x = std::max(0, column * lean_cell_px - 1);
             x <= std::min(width - 1, column * lean_cell_px); ++x) {
            const std::uint32_t word = depths[index_of(y) * index_of(width) + index_of(x)];
            least = std::min(least, shows_surface(word) ? depth_of(word) : no_depth);
        }
    }
    return least;
}

/// The depths of all corners, 24 bits; no_depth where no cell around shows a surface.
std::vector<std::uint32_t> corner_depths(const LeanDepths& lean,
                                         std::span<const CoveredCell> covered,
                                         std::span<const std::uint32_t> depths) {
    const std::size_t columns = index_of(lean.columns);
    std::vector<std::uint32_t> found(columns * index_of(lean.rows), no_depth);
    for (const CoveredCell& each : covered) {
        for (const std::size_t at : {each.corner + 0UL, each.corner + columns}) {
            found[at] = std::min(found[at], each.range.nearest);
            found[at + 1] = std::min(found[at + 1], each.range.nearest);
        }
    }
    std::size_t at = 0;
    for (int row = 0; row < lean.rows; ++row) {
        for (int column = 0; column < lean.columns; ++column, ++at) {
            if (found[at] != no_depth) {
                const std::uint32_t touching =
                    nearest_at(lean.width, lean.height, column, row, depths);
                found[at] = touching != no_depth ? touching : found[at];
            }
        }
    }
    return found;
}

/// Depths that differ by less have lean depths that differ by less than seam_depth.
constexpr auto least_seam =
    static_cast<std::uint32_t>((seam_depth - 2) * isa::depth_span / max_lean);

/// The cells whose pixels and corners differ by least_seam or more, in order.
std::vector<std::uint32_t> steep_cells(const LeanDepths& lean, std::span<const CoveredCell> covered,
                                       std::span<const std::uint32_t> corners) {
    std::vector<std::uint32_t> steep;
    for (const CoveredCell& each : covered) {
        DepthRange range = each.range;
        for (const std::size_t at : {each.corner + 0UL, each.corner + index_of(lean.columns)}) {
            range.add(corners[at]);
            range.add(corners[at + 1]);
        }
        if (range.farthest - range.nearest >= least_seam) {
            steep.push_back(each.cell);
        }
    }
    return steep;
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
    lean.mask.resize(mask_row_bytes(width) * index_of(height));
    const std::vector<CoveredCell> covered = find_covered(lean, depths);
    const std::vector<std::uint32_t> corners = corner_depths(lean, covered, depths);
    lean.corners.reserve(corners.size());
    for (const std::uint32_t corner : corners) {
        lean.corners.push_back(corner == no_depth ? std::uint16_t{0} : lean_of(corner));
    }
    lean.seams = find_seams(lean, depths, steep_cells(lean, covered, corners));
    return lean;
}

}  // namespace pxpl5::host::serve
