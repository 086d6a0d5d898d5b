// The nodes of each computer, and what a frame sends between them, before the start.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/machine/roster.hpp"
#include "host/machine/topology.hpp"

namespace pxpl5::host {

/// Bytes of message bodies between computers that a frame is expected to need.
struct NetworkForecast {
    std::uint64_t pixel_bytes = 0;    ///< Regions, from Renderers to the frame buffer.
    std::uint64_t picture_bytes = 0;  ///< The picture, from the frame buffer to the host.
    double bytes_per_triangle = 0;    ///< For a triangle in sight, in each region that it touches.
};

/// The forecast for a picture of `width` x `height` pixels and one view. It assumes that each
/// Renderer draws as many regions, and each GP as many triangles, as every other.
///
/// places     The computer of each node of `roster`, as place_nodes() returns it.
/// recording  While a run is recorded, programs include the origin of each triangle.
NetworkForecast network_forecast(const Roster& roster, const std::vector<int>& places,
                                 std::uint32_t width, std::uint32_t height, Recording recording);

/// The nodes by computer, and the forecast for 512 x 512 pixels. Empty if the engine is local. Says
/// what is missing where the number of cores of a computer is not known yet.
std::string plan_text(const Topology& topology);

}  // namespace pxpl5::host
