// How many pixels of a fast executor are enabled, and which is the first.
#pragma once

#include <cstddef>
#include <optional>

#include "host/inspect/listing/instruction_values.hpp"
#include "renderer_firmware/hal/pixel_array.hpp"

namespace pxpl5::host::inspect {

std::size_t enabled_count(const renderer::hal::PixelArray& pixels);

/// Row by row from the top left; nothing if none is enabled.
std::optional<RegionPixel> first_enabled(const renderer::hal::PixelArray& pixels);

}  // namespace pxpl5::host::inspect
