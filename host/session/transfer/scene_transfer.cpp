#include "host/session/transfer/scene_transfer.hpp"

namespace pxpl5::host::phigs {

namespace {

namespace schema = bus::schema;

/// The camera shows this part of its subject's sphere at zoom 1.
constexpr double camera_fill = 1.3;

glm::dvec3 to_patient_axes(const glm::dvec3& v) {
    return {v.x, -v.z, v.y};
}

double scale_of(const Content& content) {
    return content.radius > 0 ? scene_radius_mm / content.radius : 1.0;
}

struct Float3 {
    float x, y, z;
};

Float3 to_float(const glm::dvec3& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace

Subject scene_subject() {
    return {glm::dvec3(0), scene_radius_mm * camera_fill};
}

glm::dvec3 place_mm(const Content& content, const glm::dvec3& p) {
    return to_patient_axes((p - content.middle()) * scale_of(content));
}

bus::Payload scene_begin(std::uint32_t scene, std::span<const std::uint16_t> surface_ids) {
    schema::SceneBeginT begin;
    begin.scene = scene;
    begin.surfaces.assign(surface_ids.begin(), surface_ids.end());
    return bus::pack(begin);
}

bus::Payload scene_part(const Content& content, std::size_t slab, std::uint32_t scene,
                        std::uint16_t surface) {
    const Part& part = content.parts[slab];
    schema::ScenePartT wire;
    wire.scene = scene;
    wire.surface = surface;
    wire.slab = static_cast<std::uint32_t>(slab);
    const auto place = [&](const glm::dvec3& p) { return to_float(place_mm(content, p)); };
    wire.vertices.reserve(part.vertices.size());
    for (const ContentVertex& v : part.vertices) {
        const Float3 p = place(v.p), n = to_float(to_patient_axes(v.normal));
        wire.vertices.emplace_back(p.x, p.y, p.z, n.x, n.y, n.z);
    }
    wire.indices = part.indices;
    for (const ContentSphere& s : part.spheres) {
        const Float3 p = place(s.center);
        wire.spheres.emplace_back(p.x, p.y, p.z, static_cast<float>(s.radius * scale_of(content)));
    }
    for (const ContentLine& l : part.lines) {
        const Float3 a = place(l.from), b = place(l.to);
        wire.lines.emplace_back(a.x, a.y, a.z, b.x, b.y, b.z);
    }
    return bus::pack(wire);
}

bus::Payload scene_end(std::uint32_t scene) {
    return bus::pack(schema::SceneEndT{{}, scene});
}

}  // namespace pxpl5::host::phigs
