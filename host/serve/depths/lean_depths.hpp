// The depths of a picture, reduced for a page that shows the picture from a newer viewpoint.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace pxpl5::host::serve {

inline constexpr int lean_cell_px = 4;           ///< Width and height of a cell.
inline constexpr std::uint16_t max_lean = 4095;  ///< The depth of the far plane: 12 bits.
/// Surfaces that are farther apart than this in a cell are drawn apart: 1/85 of the way from the
/// near plane to the far plane.
inline constexpr int seam_depth = 48;

/// A cell that its corners do not describe: it shows two surfaces, one behind the other, or the
/// edge between two surfaces lies beside it.
struct Seam {
    std::uint32_t cell = 0;  ///< Row by row, from 0.
    /// Bit x + 4 y: the pixel (x, y) of the cell shows the near surface. 0: one surface.
    std::uint16_t near_pixels = 0;
    /// Depths at the upper left, upper right, lower left and lower right corner. With one surface,
    /// `near` has the depths of the corners of the picture.
    std::array<std::uint16_t, 4> near{}, far{};

    friend bool operator==(const Seam&, const Seam&) = default;
};

/// Depths at the corners of cells of 4 x 4 pixels, and which pixels show a surface. The cells at
/// the right and lower edge may be smaller. Corner (column, row) is at the upper left of the pixel
/// (4 column, 4 row), or on the edge of the picture. Source: ours; see SERVE-21.
struct LeanDepths {
    int width = 0, height = 0;  ///< Pixels of the picture.
    int columns = 0, rows = 0;  ///< Counts of corners: one more than of cells.
    /// columns * rows, top row first. 0: no pixel of the cells around the corner shows a surface.
    /// 1 (near plane) to max_lean (far plane): the depth of the nearest surface in the pixels that
    /// touch the corner, or else in the cells around the corner.
    std::vector<std::uint16_t> corners;
    /// Rows of mask_row_bytes() bytes: a bit per pixel, the left pixel lowest. 1: a surface.
    std::vector<std::uint8_t> mask;
    std::vector<Seam> seams;  ///< In order of cells.

    friend bool operator==(const LeanDepths&, const LeanDepths&) = default;

    std::size_t cell_count() const {
        return static_cast<std::size_t>(columns - 1) * static_cast<std::size_t>(rows - 1);
    }
    /// The depths of the corners of a cell, as a Seam orders them.
    std::array<std::uint16_t, 4> corners_of(std::uint32_t cell) const;
};

std::size_t mask_row_bytes(int width);

/// 1 to max_lean, linear in z after the division by w.
std::uint16_t lean_of(std::uint32_t depth);

/// depths  width * height words as FrameDone has them: bits 0..7 the surface, bits 8..31 the depth.
///
/// Throws std::invalid_argument if the number of words differs.
LeanDepths lean_depths(int width, int height, std::span<const std::uint32_t> depths);

}  // namespace pxpl5::host::serve
