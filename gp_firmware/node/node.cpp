#include "gp_firmware/node/node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "gp_firmware/node/messages.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

}  // namespace

void GpNode::receive(const bus::Message& message, bus::Outbox& out) {
    if (message.kind() == bus::Body::Topology) {
        set_machine(message);
        return;
    }
    if (!machine_) {
        throw NodeFault(FaultCode::bad_message,
                        bus::kind_name(message.kind()) + " came before Topology");
    }
    if (jobs_.size() >= max_jobs) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("{} is refused: {} jobs wait, {} are the most",
                                    bus::kind_name(message.kind()), jobs_.size(), max_jobs));
    }
    switch (message.kind()) {
        case bus::Body::VolumeHeader:
            begin_volume(*message.as<schema::VolumeHeader>(), out);
            break;
        case bus::Body::Slices:
            note_slices(message);
            break;
        case bus::Body::VolumeEnd:
            if (store_) {  // Without one, the reason has been told already.
                jobs_.push_back(EndVolume{});
            }
            break;
        case bus::Body::DropVolume:
            drop_volume(*message.as<schema::DropVolume>(), out);
            break;
        case bus::Body::SceneBegin:
            begin_scene(*message.as<schema::SceneBegin>(), out);
            break;
        case bus::Body::ScenePart:
            note_part(message);
            break;
        case bus::Body::SceneEnd:
            if (scene_) {  // As for volumes.
                jobs_.push_back(EndScene{});
            }
            break;
        case bus::Body::SetSurface:
            note_surface(*message.as<schema::SetSurface>());
            break;
        case bus::Body::RemoveSurface:
            note_removal(message.as<schema::RemoveSurface>()->surface());
            break;
        case bus::Body::FetchMesh:
            jobs_.push_back(Fetch{message.as<schema::FetchMesh>()->surface(), message.source(),
                                  message.as<schema::FetchMesh>()->origins(), nullptr});
            break;
        case bus::Body::MaskSurface:
            jobs_.push_back(Mask{message});
            break;
        case bus::Body::MeasureIsovalues:
            note_measure(message);
            break;
        case bus::Body::DrawFrame:
            begin_frame(message, out);
            break;
        case bus::Body::BeginFrame:
            note_frame(*message.as<schema::BeginFrame>());
            break;
        default:
            throw NodeFault(FaultCode::bad_message,
                            "a GP has no use for " + bus::kind_name(message.kind()));
    }
}

bool GpNode::work(bus::Outbox& out) {
    const bool measures = jobs_.empty();
    if ((measures && !measuring_) || awaits_surface()) {
        return false;
    }
    const auto forget = [&] {
        if (measures) {
            measuring_.reset();
        } else {
            jobs_.pop_front();
        }
    };
    // A job that fails is over: what comes behind it goes on.
    bool done = true;
    try {
        done = measures ? step(*measuring_, out)
                        : std::visit([&](auto& job) { return step(job, out); }, jobs_.front());
    } catch (...) {
        forget();
        rethrow_as_fault();
    }
    if (done) {
        forget();
    }
    return !jobs_.empty() || measuring_;
}

bus::NodeStatus GpNode::status() const {
    return {memory_ ? memory_->used_bytes() : 0, jobs_.size() + (measuring_ ? 1 : 0), frames_};
}

void GpNode::set_machine(const bus::Message& message) {
    const auto& topology = *message.as<schema::Topology>();
    Machine machine;
    machine.memory_bytes = topology.gp_memory_bytes();
    machine.origins = topology.recording() != schema::Recording::off;
    machine.gps = nodes_of(topology, schema::Role::gp);
    machine.renderers = nodes_of(topology, schema::Role::renderer);
    machine.frame_buffers = nodes_of(topology, schema::Role::frame_buffer);
    const bus::NodeId self = message.header().destination();
    const auto here = std::ranges::find(machine.gps, self);
    if (here == machine.gps.end()) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("node {} is none of the topology's {} GPs", self, machine.gps.size()));
    }
    if (machine.gps.size() > static_cast<std::size_t>(max_gp_count)) {
        throw NodeFault(FaultCode::bad_input, fmt::format("{} GPs in the topology, {} at most",
                                                          machine.gps.size(), max_gp_count));
    }
    machine.share = {static_cast<int>(here - machine.gps.begin()),
                     static_cast<int>(machine.gps.size())};
    jobs_.clear();
    measuring_.reset();
    surfaces_.clear();
    announced_.clear();
    store_.reset();
    memory_.emplace(machine.memory_bytes);
    machine_ = std::move(machine);
}

/// A volume or a scene takes the place of what was held.
void GpNode::drop_all(bus::Outbox& out) {
    for (const Job& job : jobs_) {
        if (const Draw* draw = std::get_if<Draw>(&job)) {
            send_nothing(*draw, out);  // Renderers wait for every GP's part.
        }
    }
    jobs_.clear();
    measuring_.reset();
    while (!surfaces_.empty()) {
        drop_surface(surfaces_.begin()->first);
    }
    store_.reset();
    announced_.clear();
    scene_ = false;
}

void GpNode::begin_volume(const schema::VolumeHeader& header, bus::Outbox& out) {
    drop_all(out);
    volume_ = header.volume();
    volume_since_ = Clock::now();
    try {
        store_ = std::make_unique<SliceStore>(shape_of(header), machine_->share, *memory_);
    } catch (const std::exception&) {
        rethrow_as_fault();
    }
}

/// Of an older volume than the one that is held there is nothing left to drop.
void GpNode::drop_volume(const schema::DropVolume& drop, bus::Outbox& out) {
    if (volume_ == drop.volume()) {
        drop_all(out);
        volume_.reset();
    }
}

void GpNode::note_slices(const bus::Message& message) {
    const auto& slices = *message.as<schema::Slices>();
    if (volume_ != slices.volume()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("slices of volume {} came, {}", slices.volume(),
                                    volume_ ? fmt::format("volume {} was announced", *volume_)
                                            : "none was announced"));
    }
    if (store_) {
        jobs_.push_back(TakeSlices{message});
    }
}

/// Whether the job in front draws a revision that has not been announced. It was sent before the
/// frame was asked for, but the frame comes from another node, and may overtake it.
bool GpNode::awaits_surface() const {
    const auto* draw = jobs_.empty() ? nullptr : std::get_if<Draw>(&jobs_.front());
    return draw != nullptr && std::ranges::any_of(draw->request.surfaces, [&](const auto& wanted) {
               const auto newest = announced_.find(wanted.surface);
               return newest != announced_.end() && newest->second < wanted.revision;
           });
}

/// No frame waits for a surface that goes: the host removes one whose new revision did not arrive.
void GpNode::note_removal(std::uint16_t surface) {
    announced_[surface] = std::numeric_limits<std::uint32_t>::max();
    jobs_.push_back(Remove{surface});
}

void GpNode::note_surface(const schema::SetSurface& set) {
    announced_[set.surface()] = set.revision();
    if (!store_) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("surface {} was asked for, but no volume is held", set.surface()));
    }
    // The newest revision wins, whether the older one waits or is half done. What lies before the
    // surface's removal is another surface's life.
    for (auto job = jobs_.end(); job != jobs_.begin();) {
        --job;
        if (const auto* removal = std::get_if<Remove>(&*job);
            removal != nullptr && removal->surface == set.surface()) {
            break;
        }
        if (const auto* older = std::get_if<Extract>(&*job);
            older != nullptr && older->surface == set.surface()) {
            job = jobs_.erase(job);
        }
    }
    // Before the frames that wait for it.
    const auto shows_it = [&](const Job& job) {
        const Draw* draw = std::get_if<Draw>(&job);
        return draw != nullptr &&
               std::ranges::any_of(draw->request.surfaces, [&](const SurfaceWanted& wanted) {
                   return wanted.surface == set.surface() && wanted.revision >= set.revision();
               });
    };
    jobs_.insert(std::ranges::find_if(jobs_, shows_it),
                 Extract{set.surface(), set.revision(), set.isovalue(),
                         static_cast<CaseRule>(set.table()), Clock::now()});
}

bool GpNode::step(TakeSlices& job, bus::Outbox& out) {
    const bus::StageClock::In loading(out.clock(), stage::load);
    const auto& slices = *job.message.as<schema::Slices>();
    const std::size_t size = slices.values()->size() / slices.slice_count();
    const std::span<const std::uint8_t> values(slices.values()->data() + job.done * size, size);
    store_->add_slice(static_cast<int>(slices.first_slice() + job.done), std::as_bytes(values));
    return ++job.done == slices.slice_count();
}

bool GpNode::step(EndVolume&, bus::Outbox& out) {
    if (!store_->complete()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("volume {} ended, but slices are missing", *volume_));
    }
    schema::VolumeReadyT ready;
    ready.volume = *volume_;
    ready.slabs = static_cast<std::uint32_t>(store_->slabs().size());
    ready.memory_bytes = memory_->used_bytes();
    ready.elapsed_us = to_us(Clock::now() - volume_since_);
    const StoreCounts counts = store_->counts();
    ready.slices = counts.slices;
    ready.rows_in_runs = counts.rows_in_runs;
    ready.runs = counts.runs;
    out.send(bus::host_id, bus::pack(ready));
    return true;
}

}  // namespace pxpl5::gp
