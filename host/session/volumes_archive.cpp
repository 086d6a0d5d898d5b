// Loads a PPHIGS archive: the GPs take its content as a scene.
#include <algorithm>

#include "host/base/stopwatch.hpp"
#include "host/session/transfer/scene_transfer.hpp"
#include "host/session/volumes.hpp"

namespace pxpl5::host {

namespace {

/// Gives all materials of the archive one gloss, because a frame has one.
void take_gloss(const phigs::Content& content, Material& material) {
    if (!content.has_specular) {
        return;
    }
    const auto& [r, g, b] = content.specular.rgb;
    material.specular = (r + g + b) / 3 / 255;
    material.specular_power = static_cast<std::uint32_t>(
        std::clamp(content.specular.power, 1.0, double{max_specular_power}));
}

}  // namespace

LoadReport Volumes::load_archive(const std::string& source) {
    LoadReport report{source};
    std::int64_t start_ns = now_ns();
    HeldArchive held{phigs::flatten(phigs::read_archive(source)), {}};
    report.read_ms = ms_since(start_ns);

    start_ns = now_ns();
    replace_content();
    std::vector<std::uint16_t> ids;
    for (const phigs::Material& material : held.content.materials) {
        Surface surface;
        surface.id = new_surface_id();
        surface.revision = 1;
        surface.color = material.color;
        surface.cull_back = material.cull_back;
        held.surfaces.push_back(surface);
        ids.push_back(surface.id);
    }
    MachinePort& machine = conversation_.machine();
    const std::vector<bus::NodeId>& gps = conversation_.gps();
    for (const bus::NodeId gp : gps) {
        machine.send(gp, phigs::scene_begin(id_, ids));
    }
    const std::vector<phigs::Part>& parts = held.content.parts;
    for (std::size_t slab = 0; slab < parts.size(); ++slab) {
        machine.send(gps[slab % gps.size()],
                     phigs::scene_part(held.content, slab, id_, ids[parts[slab].material]));
    }
    for (const bus::NodeId gp : gps) {
        machine.send(gp, phigs::scene_end(id_));
    }
    conversation_.wait_for_answers(source);  // Throws if a GP cannot hold its share.
    held.content.parts.clear();
    take_gloss(held.content, scene_.material);
    archive_ = std::move(held);
    report.distribute_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    return report;
}

}  // namespace pxpl5::host
