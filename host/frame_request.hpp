// Turns a scene into the message that asks the machine for a frame.
#pragma once

#include <span>

#include "host/scene.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// What is drawn, and where it is.
struct Stage {
    std::span<const Surface> surfaces;  ///< In drawing order.
    Subject subject;
    glm::dmat4 voxel_to_patient{1.0};
};

/// A DrawFrame message.
///
/// scene          Its own surfaces are not looked at: the stage's are.
/// frame          Number of the frame.
/// region_costs   Cycles of each region in an earlier frame of this size; may be empty.
bus::Payload frame_request(const Scene& scene, const Stage& stage, std::uint32_t frame,
                           std::span<const std::uint64_t> region_costs);

}  // namespace pxpl5::host
