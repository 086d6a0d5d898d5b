#include "gp_firmware/geometry/bin.hpp"

#include <cassert>

namespace pxpl5::gp {

RegionGrid region_grid(int width_px, int height_px, int view) {
    assert(width_px > 0);
    assert(height_px > 0);
    assert(view >= 0);
    constexpr int size = region_px;
    RegionGrid grid{width_px, height_px, (width_px + size - 1) / size,
                    (height_px + size - 1) / size, 0};
    grid.first_region = view * grid.count();
    return grid;
}

}  // namespace pxpl5::gp
