// What a verified message must satisfy beyond its form, so that nodes can trust its numbers.
#pragma once

#include <array>
#include <string>

#include "ringbus/message.hpp"

namespace pxpl5::bus {

inline constexpr std::uint32_t min_volume_voxels = 2,
                               max_volume_voxels = 4096;  ///< Along each axis; a single
                                                          ///< slice is let pass.
inline constexpr std::uint32_t max_picture_px = 8192;
inline constexpr std::uint32_t region_px = 128;
inline constexpr std::uint32_t region_pixels = region_px * region_px;
inline constexpr std::size_t max_lights = 4, max_views = 2, max_surfaces = 255;
inline constexpr std::size_t max_clip_planes = 16;
inline constexpr std::uint32_t max_specular_power = 128;
inline constexpr std::size_t max_nodes = 256;
inline constexpr std::uint32_t max_opacity = 16;  ///< Sixteenths.
/// Frames of which a picture may be the mean.
inline constexpr std::array<std::uint32_t, 3> sample_counts = {1, 4, 16};
inline constexpr double min_spacing_mm = 1e-4, max_spacing_mm = 1e3;
inline constexpr double max_smooth_mm = 100;
inline constexpr std::size_t max_isovalues = 4096;  ///< Measured at a time.
inline constexpr std::size_t max_marks = 100'000, max_mark_points = 100'000;
inline constexpr float max_mark_px = 1e5F;
inline constexpr std::uint32_t max_animation_pictures = 10'000;

/// Regions of a picture, over all views.
constexpr std::size_t region_count(std::uint32_t width, std::uint32_t height, std::size_t views) {
    const auto across = [](std::uint32_t px) { return (px + region_px - 1) / region_px; };
    return std::size_t{across(width)} * across(height) * views;
}

inline constexpr std::uint32_t max_slab = max_volume_voxels - 2;  ///< Between the last two slices.
inline constexpr std::size_t max_scene_surfaces = 255;            ///< A pixel has 8 bits for them.
inline constexpr std::uint32_t max_scene_slab = 1 << 20;          ///< Parts of one scene.
inline constexpr float max_scene_mm = 1e6F;  ///< From the origin, along each axis.
inline constexpr std::size_t max_regions = region_count(max_picture_px, max_picture_px, max_views);

/// Empty if all is well, else which field is wrong, with both values.
std::string out_of_range(const schema::Message& message);

}  // namespace pxpl5::bus
