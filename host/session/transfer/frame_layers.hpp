// A picture with one transparent surface as two pictures, of which one lies over the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host/session/transfer/frame_request.hpp"

namespace pxpl5::host {

/// How many of the surfaces are visible and have an opacity below 1.
std::size_t transparent_surfaces(std::span<const Surface> surfaces);

/// The surfaces, of which transparent ones are not visible. They stay in the list, because others
/// may be compared with them.
std::vector<Surface> without_transparent(std::span<const Surface> surfaces);

/// The surfaces of two pictures.
struct SurfaceLayers {
    std::vector<Surface> behind;  ///< Without the transparent surface.
    Surface front;                ///< The transparent surface, opaque.
    int opacity = 0;              ///< Sixteenths.
    /// Entries of drawn_surfaces() before the transparent surface. They win exact ties of depths.
    std::uint32_t entries_before = 0;
};

/// The layers of a frame. Nothing unless exactly one surface is transparent.
std::optional<SurfaceLayers> surface_layers(const Scene& scene, const Stage& stage);

/// Puts the picture of the transparent surface alone over the picture behind. Where the surface is
/// hidden or absent, its picture gets the color of the picture behind and a depth word of 0. What
/// remains is the picture of all surfaces, with the transparent surface opaque.
///
/// behind_rgba, behind_depths  The picture behind; depths as FrameDone has them.
/// rgba, depths                The picture in front, of the same size.
/// entries_before              As in SurfaceLayers.
void put_in_front(std::span<const std::uint32_t> behind_rgba,
                  std::span<const std::uint32_t> behind_depths, std::span<std::uint32_t> rgba,
                  std::span<std::uint32_t> depths, std::uint32_t entries_before);

}  // namespace pxpl5::host
