#include "host/serve/depths/lean_seams.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <optional>

#include "host/serve/depths/depth_word.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr int cell_pixels = lean_cell_px * lean_cell_px;

/// Depths of the pixels of a cell, row by row; 0 without a surface.
struct CellDepths {
    std::array<int, cell_pixels> depths{};
    int least = max_lean, most = 0;  ///< Extremes of the pixels with a surface.

    bool is_covered() const { return most > 0; }
};

CellDepths depths_of(const LeanDepths& lean, std::span<const std::uint32_t> words, int column,
                     int row) {
    CellDepths cell;
    const int x0 = column * lean_cell_px, y0 = row * lean_cell_px;
    const int across = std::min(lean_cell_px, lean.width - x0);
    const int down = std::min(lean_cell_px, lean.height - y0);
    for (int y = 0; y < down; ++y) {
        const std::size_t first =
            static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(lean.width) +
            static_cast<std::size_t>(x0);
        for (int x = 0; x < across; ++x) {
            const std::uint32_t word = words[first + static_cast<std::size_t>(x)];
            if (shows_surface(word)) {
                const int depth = lean_of(depth_of(word));
                cell.depths[static_cast<std::size_t>(y * lean_cell_px + x)] = depth;
                cell.least = std::min(cell.least, depth);
                cell.most = std::max(cell.most, depth);
            }
        }
    }
    return cell;
}

/// The least depth of the far surface; nothing if the cell shows one surface.
std::optional<int> far_from(const CellDepths& cell) {
    std::array<int, cell_pixels> sorted = cell.depths;
    std::ranges::sort(sorted);
    int gap = 0, far = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i) {
        if (sorted[i - 1] > 0 && sorted[i] - sorted[i - 1] > gap) {
            gap = sorted[i] - sorted[i - 1];
            far = sorted[i];
        }
    }
    const bool is_split = gap >= seam_depth && 2 * gap > cell.most - cell.least;
    return is_split ? std::optional(far) : std::nullopt;
}

/// The depths of the corners of the surface with depths from `least` to `most`.
std::array<std::uint16_t, 4> surface_corners(const CellDepths& cell, int least, int most,
                                             const std::array<std::uint16_t, 4>& corners) {
    std::array<std::uint16_t, 4> found{};
    for (std::size_t corner = 0; corner < corners.size(); ++corner) {
        const int x0 = corner % 2 == 0 ? 0 : lean_cell_px - 1;
        const int y0 = corner < 2 ? 0 : lean_cell_px - 1;
        int closest = std::numeric_limits<int>::max(), depth = 0, low = max_lean, high = 0;
        for (int at = 0; at < cell_pixels; ++at) {
            const int each = cell.depths[static_cast<std::size_t>(at)];
            if (each < least || each > most || each == 0) {
                continue;
            }
            low = std::min(low, each);
            high = std::max(high, each);
            const int steps = std::abs(at % lean_cell_px - x0) + std::abs(at / lean_cell_px - y0);
            if (steps < closest) {
                closest = steps;
                depth = each;
            }
        }
        const bool fits = std::abs(corners[corner] - depth) < std::max(seam_depth, high - low);
        found[corner] = fits ? corners[corner] : static_cast<std::uint16_t>(depth);
    }
    return found;
}

}  // namespace

std::vector<Seam> find_seams(const LeanDepths& lean, std::span<const std::uint32_t> depths) {
    std::vector<Seam> seams;
    std::uint32_t index = 0;
    for (int row = 0; row + 1 < lean.rows; ++row) {
        for (int column = 0; column + 1 < lean.columns; ++column, ++index) {
            const std::array<std::uint16_t, 4> corners = lean.corners_of(index);
            if (std::ranges::max(corners) == 0) {
                continue;
            }
            const CellDepths cell = depths_of(lean, depths, column, row);
            const int least = std::min<int>(cell.least, std::ranges::min(corners));
            const int most = std::max<int>(cell.most, std::ranges::max(corners));
            if (!cell.is_covered() || most - least < seam_depth) {
                continue;
            }
            const std::optional<int> far = far_from(cell);
            Seam seam{index, 0, corners, {}};
            seam.far = surface_corners(cell, far.value_or(1), max_lean, corners);
            if (far) {
                seam.near = surface_corners(cell, 1, *far - 1, corners);
            }
            for (unsigned at = 0; far && at < cell_pixels; ++at) {
                const int depth = cell.depths[at];
                const unsigned bit = depth > 0 && depth < *far ? 1U : 0U;
                seam.near_pixels = static_cast<std::uint16_t>(seam.near_pixels | bit << at);
            }
            if (far || seam.far != corners) {
                seams.push_back(seam);
            }
        }
    }
    return seams;
}

}  // namespace pxpl5::host::serve
