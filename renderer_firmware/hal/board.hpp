// All state that instructions act on.
#pragma once

#include "renderer_firmware/hal/backing_store.hpp"
#include "renderer_firmware/hal/pixel_array.hpp"
#include "renderer_firmware/hal/port.hpp"

namespace pxpl5::renderer::hal {

struct Board {
    PixelArray pixels;
    BackingStore store;
    Port port;
};

}  // namespace pxpl5::renderer::hal
