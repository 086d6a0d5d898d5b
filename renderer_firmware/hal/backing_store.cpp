#include "renderer_firmware/hal/backing_store.hpp"

namespace pxpl5::renderer::hal {

BackingStore::Words& BackingStore::open(std::uint32_t number) {
    if (!blocks_[number]) {
        blocks_[number] = std::make_unique<Words>();
    }
    return *blocks_[number];
}

}  // namespace pxpl5::renderer::hal
