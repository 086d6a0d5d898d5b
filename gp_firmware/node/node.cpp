#include "gp_firmware/node/node.hpp"

#include <fmt/format.h>

#include "gp_firmware/node/frames.hpp"
#include "gp_firmware/node/measures.hpp"
#include "gp_firmware/node/meshes.hpp"
#include "gp_firmware/node/messages.hpp"
#include "gp_firmware/node/scenes.hpp"
#include "gp_firmware/node/surfaces.hpp"
#include "gp_firmware/node/volumes.hpp"
#include "gp_firmware/node/voxels.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// Names the request of a job that fails.
bus::FaultCause cause_of(const Job& job) {
    const auto* draw = std::get_if<DrawJob>(&job);
    return {std::visit([](const auto& kind) { return kind.asked_by; }, job),
            draw != nullptr ? std::optional(draw->request.frame) : std::nullopt};
}

}  // namespace

bus::Doing GpNode::doing() {
    const Job* job = queue_.front();
    if (job == nullptr) {
        return {};
    }
    bus::Doing doing{.kind = cause_of(*job).request};
    const auto slabs = [&](std::uint16_t surface, std::size_t next) {
        doing.subject = surface;
        doing.done = static_cast<std::uint32_t>(next);
        doing.total = board_->store ? static_cast<std::uint32_t>(board_->store->slabs().size()) : 0;
    };
    if (std::holds_alternative<FileSlicesJob>(*job)) {
        doing.done = static_cast<std::uint32_t>(board_->store->received_count());
        doing.total = static_cast<std::uint32_t>(board_->store->needed_count());
    } else if (const auto* extract = std::get_if<ExtractJob>(job)) {
        slabs(extract->surface, extract->next_slab);
    } else if (const auto* fetch = std::get_if<FetchJob>(job)) {
        slabs(fetch->surface, fetch->next_slab);
    } else if (const auto* draw = std::get_if<DrawJob>(job)) {
        doing.subject = draw->request.frame;
    }
    return doing;
}

void GpNode::receive(const bus::Message& message, bus::Outbox& out) {
    if (message.kind() == bus::Body::Topology) {
        set_machine(message);
        return;
    }
    if (!board_) {
        throw NodeFault(FaultCode::bad_message,
                        bus::kind_name(message.kind()) + " came before Topology");
    }
    if (queue_.is_full()) {
        throw NodeFault(FaultCode::bad_input,
                        fmt::format("{} is refused: {} jobs wait already, and the limit is {}",
                                    bus::kind_name(message.kind()), max_jobs, max_jobs));
    }
    dispatch(message, out);
}

void GpNode::dispatch(const bus::Message& message, bus::Outbox& out) {
    switch (message.kind()) {
        case bus::Body::VolumeHeader:
            drop_all(out, freed_for(*message.as<schema::VolumeHeader>(), *board_));
            return begin_volume(*message.as<schema::VolumeHeader>(), *board_, queue_);
        case bus::Body::Slices:
            return note_slices(message, *board_, queue_);
        case bus::Body::VolumeEnd:
            if (board_->store) {  // Otherwise the volume did not fit, and a fault has been sent.
                queue_.add(VolumeEndJob{});
            }
            return;
        case bus::Body::DropVolume:
            if (board_->volume == message.as<schema::DropVolume>()->volume()) {
                drop_all(out);
                board_->volume.reset();
            }
            return;
        case bus::Body::SceneBegin:
            drop_all(out);
            return begin_scene(*message.as<schema::SceneBegin>(), *board_);
        case bus::Body::ScenePart:
            return note_part(message, *board_, queue_);
        case bus::Body::SceneEnd:
            if (board_->is_scene) {  // Otherwise a part did not fit, and a fault has been sent.
                queue_.add(SceneEndJob{});
            }
            return;
        case bus::Body::SetSurface:
            return note_surface(*message.as<schema::SetSurface>(), *board_, queue_);
        case bus::Body::RemoveSurface:
            return queue_.add_removal(message.as<schema::RemoveSurface>()->surface());
        case bus::Body::FetchMesh:
            return queue_.add(FetchJob{message.as<schema::FetchMesh>()->surface(), message.source(),
                                       message.as<schema::FetchMesh>()->origins(),
                                       message.as<schema::FetchMesh>()->detail()});
        case bus::Body::MaskSurface:
            return queue_.add(MaskJob{message});
        case bus::Body::MeasureIsovalues:
            return note_measure(message, *board_, queue_, out);
        case bus::Body::FetchVoxels:
            return note_voxels(message, *board_, queue_, out);
        case bus::Body::DrawFrame:
            return begin_frame(message, *board_, queue_, out);
        case bus::Body::BeginFrame:
            return note_frame(*message.as<schema::BeginFrame>(), *board_, queue_);
        default:
            throw NodeFault(FaultCode::bad_message,
                            "a GP does not accept " + bus::kind_name(message.kind()));
    }
}

bool GpNode::work(bus::Outbox& out) {
    Job* job = queue_.front();
    if (job == nullptr) {
        return false;
    }
    const bus::FaultCause cause = cause_of(*job);
    bool done = true;
    try {
        done = std::visit([&](auto& kind) { return step(kind, *board_, out); }, *job);
    } catch (...) {
        queue_.pop();  // The next job does not depend on the failed one.
        rethrow_as_fault(cause);
    }
    if (done) {
        queue_.pop();
    }
    return !queue_.empty();
}

bus::NodeStatus GpNode::status() const {
    if (!board_) {
        return {};
    }
    return {board_->memory.used_bytes(), queue_.size(), board_->frame.sent_count};
}

void GpNode::set_machine(const bus::Message& topology) {
    Machine machine = machine_of(topology);
    queue_.clear();
    board_.emplace(std::move(machine));
}

/// Discards the volume or scene and all jobs. Answers the discarded frames, because the Renderers
/// wait for a message of each GP, and the discarded questions, because the host counts the answers.
void GpNode::drop_all(bus::Outbox& out, Freed freed) {
    for (const Job& job : queue_.clear()) {
        if (const auto* frame = std::get_if<DrawJob>(&job)) {
            send_nothing(*frame, *board_, out);
        } else if (const auto* fetch = std::get_if<FetchJob>(&job)) {
            answer_dropped(*fetch, *board_, out);
        } else if (const auto* measurement = std::get_if<MeasureJob>(&job)) {
            answer_dropped(*measurement, out);
        } else if (const auto* voxels = std::get_if<VoxelsJob>(&job)) {
            answer_dropped(*voxels, out);
        }
    }
    drop_content(*board_, freed);
}

}  // namespace pxpl5::gp
