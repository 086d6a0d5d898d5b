// Bin: the pixels, and so the 128x128 regions, that a triangle can touch.
#pragma once

#include <algorithm>

#include "gp_firmware/geometry/transform.hpp"

namespace pxpl5::gp {

/// A region's side as a power of two: pixel >> region_bits is its column or row.
inline constexpr int region_bits = 7;
static_assert(1 << region_bits == region_px);

/// The regions of one view, counted row by row from the top left.
struct RegionGrid {
    int width_px = 0, height_px = 0;
    int columns = 0, rows = 0;
    int first_region = 0;  ///< Number of regions in earlier views.

    int count() const { return columns * rows; }
};

RegionGrid region_grid(int width_px, int height_px, int view);

/// Pixels first..last, both included; empty if last < first.
struct PixelBox {
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;

    bool empty() const { return x1 < x0 || y1 < y0; }
};

/// Returns the pixels of the picture whose centers lie in the bounding box of a, b and c.
inline PixelBox pixel_box(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c,
                          const RegionGrid& grid) {
    // The center of pixel p lies at 16 p + 8. The first center at or after v is (v + 7) / 16,
    // rounded down. The last one at or before v is (v - 8) / 16, rounded down.
    constexpr int half = subpixels / 2;
    constexpr int shift = isa::region::subpixel_bits;
    return {std::max((std::min({a.x, b.x, c.x}) + half - 1) >> shift, 0),
            std::max((std::min({a.y, b.y, c.y}) + half - 1) >> shift, 0),
            std::min((std::max({a.x, b.x, c.x}) - half) >> shift, grid.width_px - 1),
            std::min((std::max({a.y, b.y, c.y}) - half) >> shift, grid.height_px - 1)};
}

}  // namespace pxpl5::gp
