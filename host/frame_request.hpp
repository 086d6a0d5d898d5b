// Turns a scene into the message that asks the machine for a frame.
#pragma once

#include <span>

#include "host/scene.hpp"
#include "host/volume.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// A DrawFrame message.
///
/// frame          Number of the frame.
/// region_costs   Cycles of each region in an earlier frame of this size; may be empty.
bus::Payload frame_request(const Scene& scene, const Volume& volume, std::uint32_t frame,
                           std::span<const std::uint64_t> region_costs);

}  // namespace pxpl5::host
