// Turns a scene into the message that asks the machine for a frame.
#pragma once

#include <span>
#include <vector>

#include "host/scene/sample_offsets.hpp"
#include "host/scene/scene.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// The drawn content and its position.
struct Stage {
    std::span<const Surface> surfaces;  ///< In drawing order.
    Subject subject;
    glm::dmat4 voxel_to_patient{1.0};  ///< Grid to patient millimeters.
    bool has_gaps = false;             ///< Some slabs lie across missing slices.
    int detail = 0;                    ///< Detail of all surfaces; 0: exact, else see SurfaceDraw.
    std::vector<CameraMatrices> cameras = {};  ///< One, or those of the left and the right eye.
    std::span<const ScenePlane> planes = {};
};

/// One entry of a frame's list of surfaces; a pixel's surface field is its index + 1.
struct DrawnSurface {
    const Surface* surface = nullptr;
    SlabChoice slabs = SlabChoice::all;
    Color color;
};

/// The surfaces of a frame: visible surfaces in drawing order, with tinted slabs across gaps as
/// surfaces of their own. The frame's list goes on with the stage's slice planes.
std::vector<DrawnSurface> drawn_surfaces(const Scene& scene, const Stage& stage);

/// The matrices of a picture of the scene: of the left and the right eye, or of one camera.
std::vector<CameraMatrices> cameras_of(const Scene& scene, const Subject& subject);

/// Whether FrameDone carries depths besides pixels.
enum class ReadBack : std::uint8_t { pixels, pixels_and_depths };

/// A DrawFrame message.
///
/// scene          Its own surfaces are not looked at: the stage's are.
/// frame          Number of the frame.
/// region_costs   Cycles of each region in an earlier frame of this size; may be empty. The same
/// for
///                all passes of a picture, so that each region stays at its Renderer.
/// read_back      Of a pass: what its picture's last carries.
/// counts         Whether GPs and Renderers send FrameCounts.
bus::Payload frame_request(const Scene& scene, const Stage& stage, std::uint32_t frame,
                           std::span<const std::uint64_t> region_costs,
                           ReadBack read_back = ReadBack::pixels, Pass pass = {},
                           bool counts = false);

}  // namespace pxpl5::host
