#include "gp_firmware/node/scenes.hpp"

#include <fmt/format.h>

#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/stages.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

constexpr std::uint32_t scene_revision = 1;

}  // namespace

void begin_scene(const schema::SceneBegin& begin, Board& board) {
    board.volume = begin.scene();
    board.volume_since = Clock::now();
    board.is_scene = true;
    for (const std::uint16_t surface : *begin.surfaces()) {
        board.surfaces[surface].revision = scene_revision;
    }
}

void note_part(const bus::Message& message, const Board& board, JobQueue& queue) {
    const auto& part = *message.as<schema::ScenePart>();
    if (board.volume != part.scene()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("a part of scene {} arrived, but {}", part.scene(),
                        board.volume ? fmt::format("scene {} is the announced one", *board.volume)
                                     : "no scene was announced"));
    }
    if (board.is_scene) {  // Otherwise an earlier part did not fit, and a fault has been sent.
        queue.add(ScenePartJob{message});
    }
}

bool step(ScenePartJob& job, Board& board, bus::Outbox& out) {
    const bus::StageClock::In loading(out.clock(), stage::load);
    const auto& part = *job.message.as<schema::ScenePart>();
    if (!board.is_scene) {
        return true;
    }
    const auto surface = board.surfaces.find(part.surface());
    if (surface == board.surfaces.end()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("slab {} belongs to surface {}, which scene {} did not announce",
                        part.slab(), part.surface(), part.scene()));
    }
    std::vector<SlabMesh>& slabs = surface->second.slabs;
    if (!slabs.empty() && slabs.back().slab >= static_cast<int>(part.slab())) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("slab {} of surface {} arrived after slab {}", part.slab(),
                                    part.surface(), slabs.back().slab));
    }
    SlabMesh mesh = slab_mesh_of(part);
    try {
        board.memory.charge(size_bytes(mesh), fmt::format("slab {} of the scene", part.slab()),
                            "use more GPs to share the scene");
    } catch (...) {
        board.is_scene = false;  // An incomplete scene is not drawn.
        throw;
    }
    slabs.push_back(std::move(mesh));
    return true;
}

bool step(SceneEndJob&, Board& board, bus::Outbox& out) {
    if (!board.is_scene) {
        return true;
    }
    schema::VolumeReadyT ready = volume_ready(board);
    for (auto& [number, surface] : board.surfaces) {
        surface.complete = true;
        ready.slabs += static_cast<std::uint32_t>(surface.slabs.size());
    }
    out.send(bus::host_id, bus::pack(ready));
    return true;
}

}  // namespace pxpl5::gp
