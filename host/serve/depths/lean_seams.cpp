#include "host/serve/depths/lean_seams.hpp"

#include <algorithm>
#include <cassert>
#include <cstdlib>
#include <numeric>
#include <optional>
#include <utility>

#include "host/serve/depths/depth_word.hpp"

namespace pxpl5::host::serve {
namespace {

constexpr int cell_pixels = lean_cell_px * lean_cell_px;

/// Depths of the pixels of a cell, row by row; 0 without a surface.
struct CellDepths {
    std::array<int, cell_pixels> depths{};
    int least = max_lean, most = 0;  ///< Extremes of the pixels with a surface.
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
    if (cell.most - cell.least < seam_depth) {
        return std::nullopt;
    }
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

/// The pixels of a cell for each of its corners, the closest first, in order of rows and columns.
constexpr auto by_distance = [] {
    std::array<std::array<std::size_t, cell_pixels>, 4> pixels{};
    for (std::size_t corner = 0; corner < pixels.size(); ++corner) {
        const auto distance = [corner](std::size_t at) {
            const std::size_t x = at % lean_cell_px, y = at / lean_cell_px, last = lean_cell_px - 1;
            return (corner % 2 == 0 ? x : last - x) + (corner < 2 ? y : last - y);
        };
        std::iota(pixels[corner].begin(), pixels[corner].end(), 0);
        std::ranges::sort(pixels[corner], {},
                          [&](std::size_t at) { return std::pair(distance(at), at); });
    }
    return pixels;
}();

/// The depths of the corners of the surface that has pixels from `least`, above 0, to `most`.
std::array<std::uint16_t, 4> surface_corners(const CellDepths& cell, int least, int most,
                                             const std::array<std::uint16_t, 4>& corners) {
    int low = max_lean, high = 0;
    unsigned pixels = 0;  // A bit for each pixel of the surface.
    for (std::size_t at = 0; at < cell.depths.size(); ++at) {
        const int each = cell.depths[at];
        const bool is_part = each >= least && each <= most;
        low = std::min(low, is_part ? each : low);
        high = std::max(high, is_part ? each : high);
        pixels |= (is_part ? 1U : 0U) << at;
    }
    std::array<std::uint16_t, 4> found{};
    assert(pixels != 0);
    for (std::size_t corner = 0; corner < corners.size(); ++corner) {
        const std::size_t closest = *std::ranges::find_if(
            by_distance[corner], [=](std::size_t at) { return (pixels >> at & 1U) != 0; });
        const int depth = cell.depths[closest];
        const bool fits = std::abs(corners[corner] - depth) < std::max(seam_depth, high - low);
        found[corner] = fits ? corners[corner] : static_cast<std::uint16_t>(depth);
    }
    return found;
}

}  // namespace

std::vector<Seam> find_seams(const LeanDepths& lean, std::span<const std::uint32_t> depths,
                             std::span<const std::uint32_t> cells) {
    std::vector<Seam> seams;
    const auto across = static_cast<std::uint32_t>(lean.columns - 1);
    for (const std::uint32_t index : cells) {
        const std::array<std::uint16_t, 4> corners = lean.corners_of(index);
        const CellDepths cell = depths_of(lean, depths, static_cast<int>(index % across),
                                          static_cast<int>(index / across));
        const int least = std::min<int>(cell.least, std::ranges::min(corners));
        const int most = std::max<int>(cell.most, std::ranges::max(corners));
        if (most - least < seam_depth) {
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
    return seams;
}

}  // namespace pxpl5::host::serve
