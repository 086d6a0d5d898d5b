#include "renderer_firmware/hal/port.hpp"

#include <cstring>

#include "renderer_firmware/hal/pixel_array.hpp"

namespace pxpl5::renderer::hal {

void Port::turn() {
    // Four pixels of a tile's row lie side by side in both orders.
    for (std::size_t i = 0; i < stored_.size(); i += tile_side) {
        const Place p = place_of(i);
        std::memcpy(&rows_[p.y * isa::region::size_px + p.x], &stored_[i],
                    tile_side * sizeof stored_[0]);
    }
}

}  // namespace pxpl5::renderer::hal
