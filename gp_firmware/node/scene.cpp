// A GP's part of scenes: it holds what it is given, as slabs of surfaces that are complete.
#include <fmt/format.h>

#include <utility>

#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/node.hpp"
#include "gp_firmware/surface/marching_cubes.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

constexpr std::uint32_t scene_revision = 1;

}  // namespace

void GpNode::begin_scene(const schema::SceneBegin& begin, bus::Outbox& out) {
    drop_all(out);
    volume_ = begin.scene();
    volume_since_ = Clock::now();
    scene_ = true;
    for (const std::uint16_t surface : *begin.surfaces()) {
        surfaces_[surface].revision = scene_revision;
    }
}

void GpNode::note_part(const bus::Message& message) {
    const auto& part = *message.as<schema::ScenePart>();
    if (volume_ != part.scene()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("a part of scene {} came, {}", part.scene(),
                                    volume_ ? fmt::format("{} was announced", *volume_)
                                            : "none was announced"));
    }
    if (scene_) {  // Without it, the reason has been told already.
        jobs_.push_back(TakePart{message});
    }
}

bool GpNode::step(TakePart& job, bus::Outbox& out) {
    const bus::StageClock::In loading(out.clock(), stage::load);
    const auto& part = *job.message.as<schema::ScenePart>();
    if (!scene_) {
        return true;
    }
    const auto surface = surfaces_.find(part.surface());
    if (surface == surfaces_.end()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("slab {} belongs to surface {}, which scene {} did not announce",
                        part.slab(), part.surface(), part.scene()));
    }
    std::vector<SlabMesh>& slabs = surface->second.slabs;
    if (!slabs.empty() && slabs.back().slab >= static_cast<int>(part.slab())) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("slab {} of surface {} came after slab {}", part.slab(),
                                    part.surface(), slabs.back().slab));
    }
    SlabMesh mesh = slab_mesh_of(part);
    try {
        memory_->charge(size_bytes(mesh), fmt::format("slab {} of the scene", part.slab()),
                        "more GPs share a scene");
    } catch (...) {
        scene_ = false;  // What is held of it is no picture.
        rethrow_as_fault();
    }
    slabs.push_back(std::move(mesh));
    return true;
}

bool GpNode::step(EndScene&, bus::Outbox& out) {
    if (!scene_) {
        return true;
    }
    schema::VolumeReadyT ready;
    ready.volume = *volume_;
    for (auto& [number, surface] : surfaces_) {
        surface.complete = true;
        ready.slabs += static_cast<std::uint32_t>(surface.slabs.size());
    }
    ready.memory_bytes = memory_->used_bytes();
    ready.elapsed_us = static_cast<std::uint64_t>(
        std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - volume_since_)
            .count());
    out.send(bus::host_id, bus::pack(ready));
    return true;
}

}  // namespace pxpl5::gp
