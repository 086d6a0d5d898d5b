// What a session does with a PPHIGS archive: hands it to the GPs as a scene.
#include <algorithm>

#include "host/base/error.hpp"
#include "host/base/stopwatch.hpp"
#include "host/session/scene_transfer.hpp"
#include "host/session/session.hpp"

namespace pxpl5::host {

namespace {

/// The frame has one gloss for all.
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

LoadReport Session::load_archive(const std::string& source) {
    LoadReport report{source};
    std::int64_t start_ns = now_ns();
    HeldArchive held{phigs::flatten(phigs::read_archive(source)), {}};
    report.read_ms = ms_since(start_ns);

    start_ns = now_ns();
    scene.surfaces.clear();
    scene.clips.clear();
    reports_.clear();
    region_costs_.clear();
    volume_.reset();
    archive_.reset();
    std::vector<std::uint16_t> ids;
    for (const phigs::Material& material : held.content.materials) {
        Surface surface;
        surface.id = next_surface_id_++;
        surface.revision = 1;
        surface.colour = material.colour;
        surface.cull_back = material.cull_back;
        held.surfaces.push_back(surface);
        ids.push_back(surface.id);
    }
    ++volume_id_;
    begin_volume_request();
    const std::vector<bus::NodeId>& gps = machine_.gp_ids();
    for (const bus::NodeId gp : gps) {
        machine_.send(gp, phigs::scene_begin(volume_id_, ids));
    }
    const std::vector<phigs::Part>& parts = held.content.parts;
    for (std::size_t slab = 0; slab < parts.size(); ++slab) {
        machine_.send(gps[slab % gps.size()],
                      phigs::scene_part(held.content, slab, volume_id_, ids[parts[slab].material]));
    }
    for (const bus::NodeId gp : gps) {
        machine_.send(gp, phigs::scene_end(volume_id_));
    }
    wait_for_gps(source);  // Throws if a GP could not hold its share: then nothing is loaded.
    held.content.parts.clear();
    take_gloss(held.content, scene.material);
    archive_ = std::move(held);
    report.distribute_ms = ms_since(start_ns);
    report.memory_bytes = memory_bytes_;
    return report;
}

}  // namespace pxpl5::host
