// A scene's way over the ring: from an archive's content to the messages that GPs take.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/command_line.hpp"
#include "host/scene/camera.hpp"
#include "ringbus/message.hpp"

namespace pxpl5::host {

/// True for paths that end in .phigs, in letters of any case.
bool is_archive(std::string_view path);

/// An archive without its primitives, which the GPs hold.
struct ArchiveFacts {
    /// The look of the primitives of one surface.
    struct Look {
        Color color;
        bool cull_back = false;
    };

    std::string file;
    std::vector<Look> materials;       ///< In the order of first use.
    glm::dvec3 low{0}, high{0};        ///< Box around all, in the archive's units.
    double specular = 0;               ///< Gloss of most primitives, 0..1.
    std::uint32_t specular_power = 0;  ///< 0 if the archive states no gloss.
    std::size_t structures = 0, posted = 0;
    std::size_t polygons = 0, triangles = 0, spheres = 0, lines = 0;
    std::vector<std::string> notes;  ///< Differences between the archive and the drawing.
};
ArchiveFacts facts_of(const std::string& file, const bus::schema::ArchiveContent& content);

/// The sphere around every scene as the GPs hold it. A little larger than the scene, as the camera
/// fills the picture with less than that.
Subject scene_subject();

/// SceneBegin. surface_ids  One for each material.
bus::Payload scene_begin(std::uint32_t scene, std::span<const std::uint16_t> surface_ids);

/// A part of an archive as the GPs take it.
bus::Payload scene_part(const bus::schema::ScenePart& part, std::uint32_t scene,
                        std::uint16_t surface);

bus::Payload scene_end(std::uint32_t scene);

}  // namespace pxpl5::host
