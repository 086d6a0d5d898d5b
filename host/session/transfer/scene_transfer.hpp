// A scene's way over the ring: from an archive's content to the messages that GPs take.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "host/phigs/content.hpp"
#include "host/scene/camera.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host::phigs {

/// The size at which a scene is shown, whatever its units: depth and clipping are made for the
/// sizes of patients.
inline constexpr double scene_radius_mm = 100;

/// The sphere around every scene as the GPs hold it. A little larger than the scene, as the camera
/// fills the picture with less than that.
Subject scene_subject();

/// Where a point of the archive is shown, in millimeters: the scene's middle at the origin. An
/// archive's y is up and its viewer on the positive z axis; so they are seen from anterior.
glm::dvec3 place_mm(const Content& content, const glm::dvec3& p);

/// SceneBegin. surface_ids  One for each material.
bus::Payload scene_begin(std::uint32_t scene, std::span<const std::uint16_t> surface_ids);

/// ScenePart with part `slab` of the content.
bus::Payload scene_part(const Content& content, std::size_t slab, std::uint32_t scene,
                        std::uint16_t surface);

bus::Payload scene_end(std::uint32_t scene);

}  // namespace pxpl5::host::phigs
