#include "host/session/transfer/scene_transfer.hpp"

#include <algorithm>
#include <cctype>

namespace pxpl5::host {

namespace {

namespace schema = bus::schema;

/// The camera shows this part of its subject's sphere at zoom 1.
constexpr double camera_fill = 1.3;

glm::dvec3 point_of(const schema::ScenePoint& p) {
    return {p.x(), p.y(), p.z()};
}

}  // namespace

bool is_archive(std::string_view path) {
    constexpr std::string_view suffix = ".phigs";
    return path.size() > suffix.size() &&
           std::ranges::equal(path.substr(path.size() - suffix.size()), suffix, {}, [](char c) {
               return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
           });
}

ArchiveFacts facts_of(const std::string& file, const schema::ArchiveContent& content) {
    ArchiveFacts facts;
    facts.file = file;
    for (const schema::SceneMaterial* material : *content.materials()) {
        const schema::Rgb& color = material->color();
        facts.materials.push_back({{color.r(), color.g(), color.b()}, material->cull_back()});
    }
    facts.low = point_of(*content.low());
    facts.high = point_of(*content.high());
    facts.specular = content.specular();
    facts.specular_power = content.specular_power();
    facts.structures = content.structures();
    facts.posted = content.posted();
    facts.polygons = content.polygons();
    for (const schema::ScenePart* part : *content.parts()) {
        facts.triangles += part->indices()->size() / 3;
        facts.spheres += part->spheres()->size();
        facts.lines += part->lines()->size();
    }
    if (content.notes() != nullptr) {
        for (const flatbuffers::String* note : *content.notes()) {
            facts.notes.push_back(note->str());
        }
    }
    return facts;
}

Subject scene_subject() {
    return {glm::dvec3(0), scene_radius_mm * camera_fill};
}

bus::Payload scene_begin(std::uint32_t scene, std::span<const std::uint16_t> surface_ids) {
    schema::SceneBeginT begin;
    begin.scene = scene;
    begin.surfaces.assign(surface_ids.begin(), surface_ids.end());
    return bus::pack(begin);
}

bus::Payload scene_part(const schema::ScenePart& part, std::uint32_t scene, std::uint16_t surface) {
    schema::ScenePartT wire;
    part.UnPackTo(&wire);
    wire.scene = scene;
    wire.surface = surface;
    return bus::pack(wire);
}

bus::Payload scene_end(std::uint32_t scene) {
    return bus::pack(schema::SceneEndT{{}, scene});
}

}  // namespace pxpl5::host
