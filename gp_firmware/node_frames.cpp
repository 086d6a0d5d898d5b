// A GP's part of frames: the Master's beginning of one, and everybody's drawing.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "gp_firmware/node.hpp"
#include "gp_firmware/node_messages.hpp"
#include "gp_firmware/render/assignment.hpp"
#include "isa/contract/sample_sums.hpp"

namespace pxpl5::gp {

namespace {

namespace schema = bus::schema;
using bus::NodeFault;
using schema::FaultCode;

/// About 2 ms of work: new messages are looked for between pieces.
constexpr std::size_t triangles_per_piece = 50'000;

}  // namespace

void GpNode::begin_frame(const bus::Message& message, bus::Outbox& out) {
    const bus::StageClock::In assigning(out.clock(), stage::assign);
    if (machine_->share.gp_index != 0) {
        throw NodeFault(
            FaultCode::bad_message,
            fmt::format("DrawFrame came to GP {}; GP 0 is the Master", machine_->share.gp_index));
    }
    if (machine_->renderers.empty()) {
        throw NodeFault(FaultCode::bad_input, "the topology has no Renderer");
    }
    const auto& draw = *message.as<schema::DrawFrame>();
    const FrameRequest request = request_of(draw);
    if (!request.surfaces.empty()) {
        try {
            // A camera that cannot be used is refused before anybody waits for the frame.
            std::ranges::for_each(request.views, [](const Camera& c) { prepare(c); });
        } catch (const std::exception&) {
            rethrow_as_fault();
        }
    }
    const bus::Payload begin = begin_frame_message(
        draw, assign_regions(region_count(request), machine_->renderers.size(), costs_of(draw),
                             max_regions_each(draw, region_count(request))));
    for (const bus::NodeId gp : machine_->gps) {
        if (gp != message.header().destination()) {
            out.send(gp, begin);
        }
    }
    out.send(std::span<const bus::NodeId>(machine_->renderers), begin);
    out.send(std::span<const bus::NodeId>(machine_->frame_buffers), begin);
    note_frame(*schema::GetMessage(begin.bytes().data())->body_as_BeginFrame());
}

/// Regions that a Renderer can draw of the frame. Throws NodeFault if that is not enough for all.
std::size_t GpNode::max_regions_each(const schema::DrawFrame& draw, std::size_t regions) const {
    const std::size_t most = isa::max_summed_regions(draw.samples());
    const std::size_t renderers = machine_->renderers.size();
    if ((regions + renderers - 1) / renderers > most) {
        throw NodeFault(
            FaultCode::bad_input,
            fmt::format("frame {}: {} samples of {} x {} pixels are summed in {} regions, {} "
                        "Renderers have room for {}; draw a smaller picture, fewer samples, or "
                        "with more Renderers",
                        draw.frame(), draw.samples(), draw.width(), draw.height(), regions,
                        renderers, renderers * most));
    }
    return most;
}

void GpNode::note_frame(const schema::BeginFrame& begin) {
    FrameRequest request = request_of(*begin.draw());
    request.origins = machine_->origins;
    const auto* assignment = begin.assignment();
    request.assignment.assign(assignment->begin(), assignment->end());
    if (request.assignment.size() != region_count(request)) {
        throw NodeFault(FaultCode::bad_message,
                        fmt::format("frame {} assigns {} regions, it has {}", request.frame,
                                    request.assignment.size(), region_count(request)));
    }
    for (const std::uint16_t renderer : request.assignment) {
        if (renderer >= machine_->renderers.size()) {
            throw NodeFault(FaultCode::bad_message,
                            fmt::format("frame {} assigns a region to Renderer {} of {}",
                                        request.frame, renderer, machine_->renderers.size()));
        }
    }
    jobs_.push_back(Draw{std::move(request)});
}

FrameRequest GpNode::request_of(const schema::DrawFrame& draw) const {
    return frame_request(draw, store_ ? store_->shape() : VolumeShape());
}

bool GpNode::step(Draw& job, bus::Outbox& out) {
    try {
        return draw_piece(job, out);
    } catch (...) {
        send_nothing(job, out);  // Renderers wait for every GP's part.
        throw;
    }
}

bool GpNode::draw_piece(Draw& job, bus::Outbox& out) {
    if (job.stage == Draw::Stage::waiting) {
        const std::string missing = missing_surface(job.request, surfaces_);
        if (!missing.empty()) {
            throw NodeFault(FaultCode::bad_input, missing);
        }
        drawing_.begin(job.request);
        job.stage = Draw::Stage::drawing;
    }
    if (job.stage == Draw::Stage::drawing) {
        if (draw_slabs(out.clock())) {
            return false;
        }
        if (job.request.counts) {
            out.send(bus::host_id, frame_counts_message(job.request.frame, drawing_));
        }
        programs_.begin(job.request, gp_index(), machine_->renderers.size(), drawing_);
        job.stage = Draw::Stage::sending;
    }
    const bus::StageClock::In setting_up(out.clock(), stage::set_up);
    const bool more = programs_.send(drawing_, triangles_per_piece, machine_->renderers, out);
    frames_ += more ? 0 : 1;
    return !more;
}

/// As FrameDrawing::draw(), for a piece.
bool GpNode::draw_slabs(bus::StageClock* clock) {
    const bus::StageClock::In selecting(clock, stage::select);
    const std::uint64_t before_ns = drawing_.counts().transform_ns;
    const bool more = drawing_.draw(surfaces_, triangles_per_piece);
    if (clock != nullptr) {
        clock->move(stage::select, stage::transform, drawing_.counts().transform_ns - before_ns);
    }
    return more;
}

std::uint16_t GpNode::gp_index() const {
    return static_cast<std::uint16_t>(machine_->share.gp_index);
}

/// The frame, or the rest of it, without anything of this GP's: Renderers wait for every GP's part.
void GpNode::send_nothing(const Draw& job, bus::Outbox& out) {
    const std::size_t sent = job.stage == Draw::Stage::sending ? programs_.sent_count() : 0;
    programs_.drop();
    out.send(std::span<const bus::NodeId>(machine_->renderers).subspan(sent),
             empty_programs_message(job.request.frame, gp_index(), {}));
}

}  // namespace pxpl5::gp
